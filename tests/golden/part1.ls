/PROG  PART1
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "compensated";
PROG_SIZE	= 0;
CREATE		= DATE 80-01-01  TIME 00:00:00;
MODIFIED	= DATE 80-01-01  TIME 00:00:00;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 42;
MEMORY_SIZE	= 0;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:  !Compensated program PART1 for a ;
   2:  !robot ;
   3:  !Source: part.nc ;
   4:  !version 1.2.3 ;
   5:  !cell sha256:0123456789ab ;
   6:  !model sha256:cdef01234567 ;
   7:  !toolpath sha256:89abcdef0123 ;
   8:  !predicted error 0.0123 mm ;
   9:  !program sha256:456789abcdef ;
  10:  PR[9]=LPOS ;
  11:  PR[9,1]=1500.00000 ;
  12:  PR[9,2]=(-200.00000) ;
  13:  PR[9,3]=800.00000 ;
  14:  PR[9,4]=10.00000 ;
  15:  PR[9,5]=(-20.00000) ;
  16:  PR[9,6]=30.00000 ;
  17:  UFRAME[9]=PR[9] ;
  18:  UFRAME_NUM=9 ;
  19:  !tool: spindle-a ;
  20:  !PAYLOAD to set: 35.000 kg ;
  21:  !centre mm 0.0 5.0 120.0 ;
  22:  PR[9]=LPOS ;
  23:  PR[9,1]=10.00000 ;
  24:  PR[9,2]=(-20.00000) ;
  25:  PR[9,3]=250.00000 ;
  26:  PR[9,4]=0.00000 ;
  27:  PR[9,5]=30.00000 ;
  28:  PR[9,6]=0.00000 ;
  29:  UTOOL[9]=PR[9] ;
  30:  UTOOL_NUM=9 ;
  31:J P[9] 10% FINE ;
  32:J P[1] 10% FINE ;
  33:  !T1 M6 ;
  34:L P[1] 500mm/sec FINE ;
  35:L P[2] 500mm/sec CNT100 ;
  36:  !S12000 M3 ? Frasen ;
  37:L P[3] 5mm/sec FINE ;
  38:L P[4] 20mm/sec FINE ;
  39:L P[5] 20mm/sec FINE ;
  40:L P[6] 20mm/sec CNT100 ;
  41:L P[7] 30mm/sec FINE ;
  42:L P[8] 500mm/sec FINE ;
/POS
P[1]{
   GP1:
	UF : 9, UT : 9,		CONFIG : 'F U T, 0, 0, 0',
	X =     0.0000  mm,	Y =     0.0000  mm,	Z =    50.0000  mm,
	W =  180.00000 deg,	P =    0.00000 deg,	R =    0.00000 deg
};
P[2]{
   GP1:
	UF : 9, UT : 9,		CONFIG : 'F U T, 0, 0, 0',
	X =     0.0000  mm,	Y =     0.0000  mm,	Z =     5.0000  mm,
	W =  180.00000 deg,	P =    0.00000 deg,	R =    2.00000 deg
};
P[3]{
   GP1:
	UF : 9, UT : 9,		CONFIG : 'N U T, 0, 0, 0',
	X =     0.0000  mm,	Y =     0.0000  mm,	Z =     0.0000  mm,
	W =  180.00000 deg,	P =    0.00000 deg,	R =    4.00000 deg
};
P[4]{
   GP1:
	UF : 9, UT : 9,		CONFIG : 'F D T, 0, 0, 0',
	X =    40.0000  mm,	Y =     0.0000  mm,	Z =     0.0000  mm,
	W =  180.00000 deg,	P =    0.00000 deg,	R =    6.00000 deg
};
P[5]{
   GP1:
	UF : 9, UT : 9,		CONFIG : 'N D T, 0, -1, 1',
	X =    40.0000  mm,	Y =    20.0000  mm,	Z =     0.0000  mm,
	W =  180.00000 deg,	P =    0.00000 deg,	R =    8.00000 deg
};
P[6]{
   GP1:
	UF : 9, UT : 9,		CONFIG : 'F U B, 0, 0, 1',
	X =    40.0123  mm,	Y =    20.0006  mm,	Z =     0.0000  mm,
	W =  180.00000 deg,	P =    0.00000 deg,	R =   10.00000 deg
};
P[7]{
   GP1:
	UF : 9, UT : 9,		CONFIG : 'F D B, 0, 0, -1',
	X =     0.0000  mm,	Y =    20.0000  mm,	Z =     0.0000  mm,
	W =  180.00000 deg,	P =    0.00000 deg,	R =   12.00000 deg
};
P[8]{
   GP1:
	UF : 9, UT : 9,		CONFIG : 'N D B, 0, 0, 0',
	X =     0.0000  mm,	Y =    20.0000  mm,	Z =    50.0000  mm,
	W =  180.00000 deg,	P =    0.00000 deg,	R =   14.00000 deg
};
P[9]{
   GP1:
	UF : 9, UT : 9,	
	J1=    0.000000 deg,	J2= -100.000000 deg,	J3=  200.000000 deg,
	J4=    0.000000 deg,	J5=   45.000000 deg,	J6=    0.000000 deg
};
/END
