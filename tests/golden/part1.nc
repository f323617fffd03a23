%
(compensated by toolpath-compensator)
(program PART1 for a robot)
(source: part.nc)
(version 1.2.3)
(cell sha256:0123456789ab)
(model sha256:cdef01234567)
(toolpath sha256:89abcdef0123)
(predicted error 0.0123 mm)
(program sha256:456789abcdef)
(G54 is the work object: xyz 1500 -200 800 mm, rpy 10 -20 30 deg in the base)
G21 G90 G94 G17 G40 G54
(T1 M6)
(tool 1: spindle-a)
T1 M6
G43.4 H1
G0 X0.0000 Y0.0000 Z50.0000 I0.0000000 J0.0000000 K1.0000000
Z5.0000
(S12000 M3 ? Frasen)
G1 Z0.0000 F300
X40.0000 F1200
G61 Y20.0000
G64 X40.0123 Y20.0006
X0.0000 Y20.0000 F1800
G0 Z50.0000
G49
M30
%
