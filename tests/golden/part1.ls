/PROG  PART1
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "compensated";
PROG_SIZE	= 0;
CREATE		= DATE 80-01-01  TIME 00:00:00;
MODIFIED	= DATE 80-01-01  TIME 00:00:00;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 36;
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
   4:  PR[9]=LPOS ;
   5:  PR[9,1]=1500.00000 ;
   6:  PR[9,2]=(-200.00000) ;
   7:  PR[9,3]=800.00000 ;
   8:  PR[9,4]=10.00000 ;
   9:  PR[9,5]=(-20.00000) ;
  10:  PR[9,6]=30.00000 ;
  11:  UFRAME[9]=PR[9] ;
  12:  UFRAME_NUM=9 ;
  13:  !tool: spindle-a ;
  14:  !PAYLOAD to set: 35.000 kg ;
  15:  !centre mm 0.0 5.0 120.0 ;
  16:  PR[9]=LPOS ;
  17:  PR[9,1]=10.00000 ;
  18:  PR[9,2]=(-20.00000) ;
  19:  PR[9,3]=250.00000 ;
  20:  PR[9,4]=0.00000 ;
  21:  PR[9,5]=30.00000 ;
  22:  PR[9,6]=0.00000 ;
  23:  UTOOL[9]=PR[9] ;
  24:  UTOOL_NUM=9 ;
  25:J P[9] 10% FINE ;
  26:J P[1] 10% FINE ;
  27:  !T1 M6 ;
  28:L P[1] 500mm/sec FINE ;
  29:L P[2] 500mm/sec CNT100 ;
  30:  !S12000 M3 ? Frasen ;
  31:L P[3] 5mm/sec FINE ;
  32:L P[4] 20mm/sec FINE ;
  33:L P[5] 20mm/sec FINE ;
  34:L P[6] 20mm/sec CNT100 ;
  35:L P[7] 30mm/sec FINE ;
  36:L P[8] 500mm/sec FINE ;
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
