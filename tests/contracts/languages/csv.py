"""CSV poses in the contract suites."""

from __future__ import annotations

from tests.contracts.sample import ReadSample, Sample, WrittenSample

HEADER = "x_mm,y_mm,z_mm,i,j,k,feed_mm_min,kind\n"
GOOD = "1,2,3,0,0,1,60,cut\n"
#: File: line and words of the refusal.
REFUSED: dict[str, tuple[int | None, str]] = {
    "x_mm,y_mm,i,j,k\n1,2,0,0,1\n": (1, "missing column z_mm"),
    "x_mm,y_mm,z_mm\n1,2,0\n": (1, "missing column i, j, k (or qw"),
    "x_mm,y_mm,z_mm,qw,qx,qy\n1,2,0,1,0,0\n": (1, "missing column qz"),
    "x_mm,y_mm,z_mm,i,j,k,qw,qx,qy,qz\n": (1, "both"),
    "x,y,z,i,j,k\n1,2,3,0,0,1\n": (1, "unknown column 'x'"),
    "x_mm,y_mm,z_mm,i,j,k,i\n1,2,3,0,0,1,1\n": (1, "'i' stands twice"),
    "x_mm;y_mm;z_mm;i;j;k\n1,0;2;3;0;0;1\n": (1, "not separated by commas"),
    "x_mm\ty_mm\tz_mm\ti\tj\tk\n1\t2\t3\t0\t0\t1\n": (1, "not separated by commas"),
    "12.5,-3,40,0.6,0,0.8\n": (1, "tip to the spindle: x_mm,y_mm,z_mm,i,j,k"),
    "12.5,-3,40,0.6,0,0.8,600\n": (1, "feed in mm/min: x_mm,y_mm,z_mm,i,j,k,feed_mm_min"),
    "12.5,-3,40,0,0.6,0.8,0\n": (1, "spindle and the feed in mm/min: x_mm"),
    "12.5,-3,40,0.5,-0.5,0.5,0.5\n": (1, "quaternion of the TCP: x_mm,y_mm,z_mm,qw,qx,qy,qz"),
    "12.5,-3,40\n": (1, "add the tool axis to every row, such as 0,0,1: x_mm,y_mm,z_mm,i,j,k"),
    "12.5,-3,40,45,0,30\n": (1, "a name for each column that the file has"),
    "12.5 -3 40 0.6 0 0.8\n": (1, "Put commas between the columns. Paste this line on top"),
    HEADER: (None, "no pose"),
    HEADER + GOOD + "1,2,3,0,0,1,60\n": (3, "7 values, the header has 8"),
    HEADER + GOOD + "1,2\n": (3, "2 values"),
    HEADER + GOOD + "1,5,2,3,0,0,1,60,cut\n": (3, "9 values"),
    HEADER + GOOD + GOOD + "1,zwei,3,0,0,1,60,cut\n": (4, "column y_mm: 'zwei'"),
    HEADER + "1,2,,0,0,1,60,cut\n": (2, "column z_mm: an empty cell"),
    HEADER + GOOD + "1,2,nan,0,0,1,60,cut\n": (3, "column z_mm: nan"),
    HEADER + GOOD + "-inf,2,3,0,0,1,60,cut\n": (3, "column x_mm: -inf"),
    HEADER + GOOD + "1e400,2,3,0,0,1,60,cut\n": (3, "column x_mm: inf"),
    HEADER + GOOD + "2e6,2,3,0,0,1,60,cut\n": (3, "beyond 1e+06"),
    HEADER + GOOD + "1,2,3,0,0,0,60,cut\n": (3, "i, j, k: length 0"),
    HEADER + GOOD + "1,2,3,0,0.1,1,60,cut\n": (3, "i, j, k: length 1.00499"),
    "x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,0,0,0,0\n": (2, "qw, qx, qy, qz: length 0"),
    HEADER + GOOD + "1,2,3,0,0,1,60,drill\n": (3, "column kind: 'drill'"),
    HEADER + GOOD + "1,2,3,0,0,1,60,cutting_with_long_word\n": (3, "'cutting_with_long_word'"),
    HEADER + GOOD + "1,2,3,0,0,1,0,cut\n": (3, "column feed_mm_min: 0, above 0"),
    HEADER + GOOD + "1,2,3,0,0,1,-5,rapid\n": (3, "column feed_mm_min: -5"),
    "x_mm,y_mm,z_mm,i,j,k,spindle\n1,2,3,0,0,1,cw\n": (2, "column spindle: 'cw'"),
    "x_mm,y_mm,z_mm,i,j,k,spindle_rpm\n1,2,3,0,0,1,-900\n": (2, "column spindle_rpm: -900"),
    HEADER + GOOD + "<<<<<<< HEAD\n" + GOOD: (3, "merge-conflict"),
    ";TYPE:Skirt\nG1 X1\n": (1, "unknown column ';TYPE:Skirt'"),
    "x_mm;y_mm;z_mm;i;j;k\n0;0;5;0;0;1\n": (1, "not separated by commas"),
}

SAMPLE = Sample(
    read=ReadSample(
        text=HEADER + "0,0,5,0,0,1,0,rapid\n10,0,0,0,0,1,600,cut\n10,-4,0,0,0,1,600,cut\n10,-4,5,0,0,1,0,rapid\n",
        pieces='x_mm,y_mm,z_mm,i,j,k ,kind ,feed_mm_min 1,2,3,0,0,1 , cut " nan 1e999 qw',
        end_word=False,
        twice="two files in one",
        refused=tuple((text, *expected) for text, expected in REFUSED.items()),
    ),
    written=WrittenSample(split=False, start=0),
    examples=2,
)
