"""Small files as devices write them, made up for the tests: of each, what it has to give."""

from __future__ import annotations

SA = """// SpatialAnalyzer SA 2024.2.0923.4 ( x64 )
// Points Relative to Coordinate Frame 'A::WORLD'
// AXES = CARTESIAN: X,  Y,  Z (mm)
Run,  Fast,  0,  100.000000,  -200.500000,  30.250000,  02/12/25 16:56:08
Run,  Fast,  1,  101.000000,  -200.500000,  30.250000,  02/12/25 16:56:08
Run,  Fast,  2,  102.000000,  -200.500000,  30.250000,  02/12/25 16:56:09
"""
SA_BARE = "1,  2296.603379,  -2416.181291,  -442.803485\n2,  2331.349757,  -2328.039341,  -547.862927\n" * 2

PCDMIS = """DATE=17-Sep-25                       TIME=10:04:11 AM\r
PART NAME  : BRACKET\r
DIM LOC1= LOCATION OF PLANE PLN4  UNITS=MM\r
AX    NOMINAL       +TOL       -TOL       MEAS        DEV     OUTTOL\r
Y       42.500      0.200      0.200     42.520      0.020      0.000 ----#----\r
DIM #8FLAT1= FLATNESS OF PLANE PLN2  UNITS=MM\r
AX    NOMINAL       +TOL       -TOL       MEAS        DEV     OUTTOL\r
M        0.000      0.500      0.000      0.014      0.014      0.000 #--------\r
DIM LOC2= LOCATION OF POINT PNT1  UNITS=MM\r
AX    NOMINAL       +TOL       -TOL       MEAS        DEV     OUTTOL\r
X       10.000      0.100      0.100     10.030      0.030      0.000 ------#--\r
PART NUMBER=BRACKET    DATE=17-Sep-25     TIME=10:04:11 AM           PAGE#=2\r
Y        5.000      0.100      0.100      5.040      0.040      0.000 ------#--\r
Z       -7.000      0.100      0.100     -7.000      0.000      0.000 ----#----\r
DIM LOC3= POSITION OF CIRCLE CIR9  UNITS=MM\r
AX    NOMINAL       +TOL       -TOL      BONUS       MEAS         DEV     OUTTOL\r
X       0.000                                      -0.042      -0.042           \r
DIM LOC4= LOCATION OF POINT PNT2  UNITS=MM\r
AX    NOMINAL       +TOL       -TOL       MEAS        DEV     OUTTOL\r
T        0.000      0.100      0.050     -0.061     -0.061      0.011 <-------\r
"""
NOMINALS = "name,x,y,z,i,j,k\nPLN4,1,42.5,3,0,1,0\nPNT1,10,5,-7,0.6,0.8,0\nPNT2,4,5,6,0,0,-1\n"

QIF = """<?xml version="1.0" encoding="UTF-8"?>
<QIFDocument xmlns="http://qifstandards.org/xsd/qif3" versionQIF="3.0.0" idMax="40">
  <FileUnits><PrimaryUnits><LinearUnit><SIUnitName>meter</SIUnitName><UnitName>inch</UnitName>
    <UnitConversion><Factor>0.0254</Factor></UnitConversion></LinearUnit></PrimaryUnits></FileUnits>
  <Features>
    <FeatureNominals n="3">
      <PointFeatureNominal id="1"><Location>1 2 3</Location><Normal>0 0 1</Normal></PointFeatureNominal>
      <PointFeatureNominal id="2"><Location>4 5 6</Location><Normal>0.6 0.8 0</Normal></PointFeatureNominal>
      <CircleFeatureNominal id="3"><Location>0 0 0</Location><Normal>0 0 1</Normal></CircleFeatureNominal>
    </FeatureNominals>
    <FeatureItems n="4">
      <PointFeatureItem id="11"><FeatureNominalId>1</FeatureNominalId><FeatureName>A</FeatureName></PointFeatureItem>
      <PointFeatureItem id="12"><FeatureNominalId>2</FeatureNominalId><FeatureName>B</FeatureName></PointFeatureItem>
      <PointFeatureItem id="14"><FeatureNominalId>2</FeatureNominalId><FeatureName>C</FeatureName></PointFeatureItem>
      <CircleFeatureItem id="13"><FeatureNominalId>3</FeatureNominalId><FeatureName>H</FeatureName></CircleFeatureItem>
    </FeatureItems>
  </Features>
  <MeasurementResults id="39"><MeasuredFeatures n="3">
    <PointFeatureMeasurement id="22"><FeatureItemId>12</FeatureItemId>
      <Location>4.01 5.02 6.5</Location></PointFeatureMeasurement>
    <PointFeatureMeasurement id="21"><FeatureItemId>11</FeatureItemId>
      <Location>1 2 2.999</Location></PointFeatureMeasurement>
    <CircleFeatureMeasurement id="23"><FeatureItemId>13</FeatureItemId>
      <Location>0 0 0</Location></CircleFeatureMeasurement>
  </MeasuredFeatures>
  <PointProfileCharacteristicMeasurement id="31"><FeatureMeasurementIds n="1"><Id>22</Id></FeatureMeasurementIds>
    <Value>0.022</Value></PointProfileCharacteristicMeasurement>
  </MeasurementResults>
</QIFDocument>
"""

PROBE = """RESULTSFILE PART1
START
TOOLPATH Old
G330 N1 A0. B0. C0. X0 Y0 Z0 I0 R0
G800 N1 X0. Y0. Z0. I0. J0. K1. O0. U0.005 L0.005
G801 N1 X0. Y0. Z1. R1.
END
START
TOOLPATH Sleeve
G331 N1 A-90. B0. C0. X0. Y1.8 Z0.
G330 N1 A0. B0. C0. X0 Y0 Z0 I0 R0
G800 N1 X-0.4394 Y0.5291 Z-0.0753 I0.63893 J-0.76927 K0. O0. U0.005 L0.005
G801 N1 X-.4187 Y.5040 Z-.0753 R.0345
G800 N2 X1. Y2. Z3. I0. J0. K1. O.1 U0.05 L0.05
G801 N2 X1. Y2. Z3.7 R.5
G800 N3 X1. Y2. Z3. I0. J0. K1.
END
"""

TABLE = "x_mm,y_mm,z_mm,index,spindle load\n1,2,3,0,40\n4,5,6,2.5,41\n"
BAR = "angle;radius [µm];index\n0;150001,5;3\n90;150003;4\n"
SAMPLES = {"spatial-analyzer": SA, "pc-dmis": PCDMIS, "qif": QIF, "probe-results": PROBE, "csv": TABLE}
