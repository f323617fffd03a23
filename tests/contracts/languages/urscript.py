"""URScript in the contract suites."""

from __future__ import annotations

from tests.contracts.sample import FilterSample, ReadSample, Sample, WrittenSample
from tests.oracles.robot_programs import script
from toolpaths.writing.marker import MARKER

A, B, C = "p[0.1, 0, 0, 3.14159265, 0, 0]", "p[0.2, 0.05, 0, 0, 3, 0]", "p[.3,0,0,1e-1,0,0]"
Q = "[0, -1.57, 1.57, 0, 0.5, -0.1]"
#: Lines of a function: line and words of the refusal.
REFUSED: list[tuple[list[str], int, str]] = [
    (["while i < 5:", f"  movel({A})", "end"], 2, "decides about 'movel"),
    ([f"if x == 1:\n    movel({A})\n  end"], 2, "decides about"),
    (["if True:\n    halt\n  end"], 2, "decides about"),
    (["x = get_actual_tcp_pose()", "movel(x)"], 3, "get_actual_tcp_pose() is computed while"),
    (["x = get_actual_tcp_pose()", "movel(pose_trans(x, p[0,0,0,0,0,0]))"], 3, "computed while"),
    (["if 1 == 1:\n    x = 2\n  end", "movel(p[x,0,0,0,0,0])"], 5, "which may or may not run"),
    ([f"thread t():\n    movel({A})\n  end", "h = run t()"], 5, "the thread t moves the arm: 'movel("),
    (["run t()"], 2, "the thread t is not in the file"),
    (["while (True):\n    movel(" + A + ")\n  end"], 2, "in PolyScope clear 'Program Loops Forever'"),
    (["servoj([0,0,0,0,0,0])"], 2, "servoj() is not read"),
    (["speedl([0,0,0,0,0,0])"], 2, "speedl()"),
    (["movel(p[1,2,3])"], 2, "a pose of 3 numbers"),
    (["movej([1,2,3])"], 2, "no six joints"),
    ([f"movel({A}, v=0)"], 2, "v = 0"),
    ([f"movel({A}, r=-1)"], 2, "r = -1"),
    ([f"movel({A}, q=1)"], 2, "movel with"),
    ([f"movel({A}, v=True)"], 2, "movel with v"),
    ([f"movel({A}) movel({A})"], 2, "text behind"),
    ([f"movel({A}"], 2, "where"),
    ([f"movec({A})"], 2, "without its poses"),
    ([f"movel({B})", f"movec({A}, {C}, mode=1)"], 3, "mode 1"),
    ([f"movec({Q}, {A})"], 2, "joint angles"),
    (["set_tcp(5)"], 2, "set_tcp"),
    (["set_payload(p[0,0,0,0,0,0])"], 2, "set_payload"),
    (["do something"], 2, "is not read"),
    (["unknown()"], 2, "unknown() is not read"),
    ([f"movel({A}, v=1/0)"], 2, "division by 0"),
    (["movel(" + "(" * 99 + "1"], 2, "nested too deep"),
    ([f"movel({A}, v=w)"], 2, "w has no value yet"),
    (["movel(p[0,0,0,0,-1e999,0])"], 2, "too large"),
    (["force_mode(1)"], 2, "force_mode() is not read"),
    (["x = force_mode(1)"], 2, "computed while"),
    (["movel(p[2000,0,0,0,0,0])"], 2, "beyond 1000 m"),
    ([f"movec({A}, {C})"], 2, "an arc whose start is not given"),
    ([f"movel({A})", f"movec({A}, {C})"], 3, "on one line"),
]
MISTAKES: list[tuple[str | bytes, str]] = [
    ("", "empty"),
    (b"\x00\x01", "binary"),
    ("def a():\n", "'def' without its 'end'"),
    ("end\n", "'end' without a block"),
    ("def a:\nend\n", "Expected a name"),
    ("else:\n", "'else' without an if"),
    ("<<<<<<< a\nend\n", "merge-conflict"),
    ("def a():\nend\na()\n", "no move"),
    ("G0 X1\n", "'G0 X1' is not read"),
    ("def a(x):\nend\na()\n", "0 arguments"),
    ("def a():\n  a()\nend\na()\n", "calling itself"),
    ("while True:\n" * 70, "nested deeper"),
    (
        "def a():\n  sync()\n  sync()\nend\n"
        + "".join(f"def a{i}():\n" + f"  a{i - 1 if i else ''}()\n" * 9 + "end\n" for i in range(9))
        + "a8()\n",
        "more often",
    ),
    (script("movel(p[" + "-" * 3000 + "1, 0, 0, 0, 0, 0])"), "nested too deep"),
    (
        "".join(f"def a{i}():\n  a{i + 1}()\nend\n" for i in range(2000)) + "while x:\n  a0()\nend\n",
        "decides about 'a0()'",
    ),
    ("".join(f"def a{i}():\n  a{i - 1}()\nend\n" for i in range(1, 99)) + "a98()\n", "calling itself"),
    (script("x = " + "(" * 5000), "no move"),
    (script("while x" + " " * 200_000 + "y:", "end"), "no move"),
    ("def a" + " " * 200_000 + "b():\nend\n", "Expected a name"),
    (script("x = [" + "1," * 100_000), "no move"),
    (script("movel(" + " " * 200_000 + "x"), "x has no value yet"),
]
WHOLE = script(
    "v = 0.1",
    f"movel({A}, v=v)",
    f"movec({B}, {C}, 1.2, v)",
    "while x:",
    "  sync()",
    "end",
    "set_tcp(p[0,0,1,0,0,0])",
    f"movep(pose_trans(p[1,0,0,0,0,0], {B}), v=d2r(2))",
)

MOVEJ, MOVEL = "movej(p[0,0,0.05,3.14159265,0,0])", "movel(P,v=0.02)"
CUT = "def cut():\n  movel(p[0,0,0,3.1,0,0],v=0.02)\n  return 1\nend\n"
SETS = "P=p[0.001,0.002,0.003,3.14159265,0,0]\ndef foo():\n  global P=p[0,0,0.5,3.1,0,0]\n  return 1\nend\n"
#: The same, as whole programs: a pose that is not known any more, moves that would be lost.
LOST = (
    (script("P=p[0,0,0,3.1,0,0]", MOVEJ, "if get_digital_in(1):", "  P[2]=0.5", "end", MOVEL), 7, "line 5"),
    (script(MOVEJ, "if get_digital_in(1):", "  foo()", "end", MOVEL, before=SETS), 11, "line 3"),
    (script(MOVEJ, "x=foo()", MOVEL, before=SETS), 9, "line 3"),
    (script(MOVEJ, "textmsg(foo())", MOVEL, before=SETS), 9, "line 3"),
    (script(MOVEJ, "t=run go()", MOVEL, before=SETS + "thread go():\n  foo()\nend\n"), 12, "line 3"),
    (script(MOVEJ, "x=cut()", before=CUT), 7, "calls a function that moves the arm"),
    (script(MOVEJ, "textmsg(cut())", before=CUT), 7, "calls a function that moves the arm"),
    (script(MOVEJ, "if x==1:", "  sync()", "elif cut()==1:", "  sync()", "end", before=CUT), 7, "decides"),
    (script(MOVEJ, "while cut()==1:", "  sync()", "end", before=CUT), 7, "decides"),
    (script(MOVEJ, "go()", before=CUT + "def go():\n  return cut()\nend\n"), 6, "moves the arm"),
    (script(MOVEJ) * 2, 5, "Two programs in one file"),
    (script("P=p[0,0,0,3.1,0,0]", "movel(p[P[6],0,0,0,0,0])"), 3, "P has no element 6"),
)
SPELLED = (
    (script("P=p[0.001,0.002,0.003,3.14159265,0,0]", "L=[P,P]", MOVEJ, "movel(L[1])"), (1, 2, 3)),
    (script("P=p[0.001,0.002,0.003,3.1,0,0]", MOVEJ, "movel(p[P[0],P[1],P[2]+0.05,P[3],P[4],0])"), (1, 2, 53)),
    (
        script("P=p[0,0,0,3.1,0,0]", MOVEJ, "go()", MOVEL, before="def go():\n  local P=p[0,0,1,0,0,0]\nend\n"),
        (0, 0, 0),
    ),
)

#: Named poses that two moves use, a frame, a blend radius in the fifth place.
SOURCE = """def part():
  f = p[1, 0, 0, 0, 0, 0.5]
  wp_1 = p[0.100000, 0.000000, 0.000000, 0.000000, 3.100000, 0.000000]
  wp_2 = p[0.300, 0.100, 0.000, 0, 3.1, 0]
  v_rapid = 0.5
  set_tcp(p[0, 0, 0.1, 0, 0, 0])
  movej([0, -1.5, 1.5, 0, 0.5, 0], a=1.4, v=0.35)
  movel(p[0.1, 0, 0.05, 0, 3.1, 0], v=v_rapid)
  # cut
  movel(wp_1, a=1.2, v=0.02, r=0.001)  # first
  movel(p[0.200000, 0.000000, 0.000000, 2.200000, 2.250000, 0.010000], 1.2, 0.02, 0, 0.005)
  movel(wp_2, a=1.2, v=0.02)
  set_digital_out(1, True)
  movel(pose_trans(f, p[-0.7, 0.3, 0.01, 0, 0, 0]), a=1.2, v=0.02, r=0.002)
  movel(wp_2, a=1.2, v=0.03)
end

part()
"""
ARC = (
    "def a():\n  wp = p[0.01, 0.01, 0, 0, 0, 0]\n  movel(p[0, 0, 0, 0, 3, 0], v=0.1)\n"
    "  movec(p[0.01, 0.01, 0, 0, 0, 0], p[0.02, 0, 0, 0, 3, 0], 1.2, 0.02, 0.001)\n"
    "  movel(p[0.03, 0, 0, 0, 3, 0], v=0.1)\nend\n"
)
TIMED = SOURCE.replace("v_rapid =", "t_cut = 2.0\n  v_rapid =")

SAMPLE = Sample(
    read=ReadSample(
        text="def part():\n  v_rapid = 1\n  w = 3.141592653589793\n  movej(p[0, 0, 0.005, w, 0, 0])\n"
        "  movel(p[0.01, 0, 0, w, 0, 0], v=0.01)\n  movel(p[0.01, -0.004, 0, w, 0, 0], v=0.01)\n"
        "  movel(p[0.01, -0.004, 0.005, w, 0, 0], v=v_rapid)\nend\n",
        pieces="def a(): end movel( p[0,0,0,0,0,1] , v=0.1 ) movec( set_tcp( pose_trans( while x: if 1: "
        'v = 2 * ( # 1e999 a() " run if x: def thread t(): /0 movep( d2r(2) sync() 1.2,',
        twice="",
        whole=WHOLE,
        refused=(*((script(*lines), line, words) for lines, line, words in REFUSED), *LOST),
        mistakes=tuple(MISTAKES),
        spelled=SPELLED,
    ),
    written=WrittenSample(rotation=2e-8, frame=1e-8, most_lines=2600, fastest="5 m/s"),
    filtered=FilterSample(
        source=SOURCE,
        marker=(2, (f"  # {MARKER}",)),
        lines=(5, 6),
        shown=(
            "  wp_1 = p[0.1001200, -0.0003400, 0.0005600, ",
            "], 1.2, 0.02, 0, 0.005)",
            "]), a=1.2, v=0.02, r=0.002)",
        ),
        position=1e-7,
        arc=(ARC, "movec"),
        arc_told=("an arc became straight lines",),
        by_time=tuple(
            (
                TIMED.replace("movel(wp_2, a=1.2, v=0.02)", f"movel(wp_2, {time})"),
                4,
                "part.script:13: a move by time cannot be divided. Give it v instead of t",
                f", {time})\n",
            )
            for time in ("a=1.2, t=2.0", "1.2, 0.02, t_cut")
        ),
        twice=(
            "def go():\n  movel(p[0, 0, 0, 0, 3, 0], v=0.1)\nend\ngo()\ngo()\n",
            "part.script:2: this move runs more than once",
        ),
        real={},
    ),
    examples=3,
)
