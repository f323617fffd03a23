"""VAL3 in the contract suites."""

from __future__ import annotations

from tests.contracts.sample import ReadSample, Sample, WrittenSample

HEAD = (
    '<?xml version="1.0" encoding="utf-8"?>\n'
    '<Programs xmlns="http://www.staubli.com/robotics/VAL3/Program/2">\n'
    '  <Program name="part" access="public">\n'
)
NAMES = {"jHome": "jointRx", "t": "tool", "mAir": "mdesc", "m": "mdesc", **dict.fromkeys(("p5", "pa", "pb"), "pointRx")}
LOCALS = "".join(f'      <Local name="{n}" type="{k}" xsi:type="array" size="1" />\n' for n, k in NAMES.items())


def program(*lines: str, locals_: str = LOCALS) -> str:
    """A program; its first statement stands in line 15 where the locals are those above."""
    body = "".join(f"  {line}\n" for line in lines)
    code = f"    <Code><![CDATA[\nbegin\n{body}end\n    ]]></Code>\n  </Program>\n</Programs>\n"
    return f"{HEAD}    <Locals>\n{locals_}    </Locals>\n{code}"


SET = ("p5.trsf={0,0,50,180,0,0}", "pa.trsf={12.5,-3,0,180,0,0}", "m.tvel=10", "movej(p5,t,mAir)")
LINE = 15 + len(SET)
#: Line behind a rapid: words of the refusal, which names this line.
REFUSED = [
    ("movel(pb[7],t,m)", "pb[7] is not in the data"),
    ("movel(herej(),t,m)", "herej() is not in the data"),
    ("movel(m,t,m)", "m is a mdesc, no point"),
    ("movel(pa,t)", "is not read"),
    ("movel(appro(pa,{0,0,nDown,0,0,0}),t,m)", "no trsf of six numbers"),
    ("movel(jHome,t,m)", "a line to joint angles"),
    ("setFrame(pa,pb,p5,fWork)", "known only while"),
    ("goto again", "known only while"),
    ("return 1", "it is not read so"),
    ("fooBar(1)", "does not know it"),
    ("link(pQ,world)", "pQ is not in the data"),
]  # fmt: skip
#: Lines, and which of them the next is refused for.
LATER = [
    (("if di1==true", "movel(pa,t,m)", "endIf"), 1, "'if di1==true' (line 19) decides about 'movel(pa,t,m)'"),
    (("pa.trsf.x=nStep*2", "movel(pa,t,m)"), 1, "computed in line 19"),
    (("if di1==true", "pa.trsf.x=3", "endIf", "movel(pa,t,m)"), 3, "set in line 20, which may or may not run"),
    (("movej(pQ,t,mAir)", "movel(pa,t,m)"), 1, "starts where 'movej(pQ,t,mAir)' (line 19) leads"),
    (("m.tvel=0", "movel(pa,t,m)"), 1, "as speed"),
    (("while true", "movel(pa,t,m)", "endWhile"), 1, "decides about"),
    (("while true", "delay(1)"), 0, "not closed"),
    (("pb.trsf={25,-6,0,180,0,0}", "movel(pa,t,m)", "movec(pa,pb,t,m)"), 2, "one line"),
]  # fmt: skip
DATA = """<?xml version="1.0" encoding="utf-8"?>
<Database xmlns="http://www.staubli.com/robotics/VAL3/Data/2">
  <Datas>
    <Data name="fWork" access="private" xsi:type="array" type="frame" size="1">
      <Value key="0" x="800" y="-100" z="200" rx="10" fatherId="world[0]" />
    </Data>
    <Data name="tMill" access="private" xsi:type="array" type="tool" size="2">
      <Value key="0" z="150" fatherId="flange[0]" />
      <Value key="1" z="30" fatherId="tMill[0]" />
    </Data>
    <Data name="pW" access="private" xsi:type="array" type="pointRx" size="3">
      <Value key="0" x="1" y="2" z="3" rx="180" fatherId="fWork[0]" />
      <Value key="1" x="11" y="-2" z="3" rx="180" fatherId="fWork[0]" />
      <Value key="2" x="21" y="2" z="3" rx="180" ry="5" fatherId="fWork[0]" />
    </Data>
    <Data name="jHome" access="private" xsi:type="array" type="jointRx" size="1">
      <Value key="0" j3="90" j5="60" />
    </Data>
    <Data name="mCut" access="private" xsi:type="array" type="mdesc" size="1">
      <Value key="0" tmax="20" blend="Cartesian" leave="0.5" reach="0.25" />
    </Data>
  </Datas>
</Database>
"""
WHOLE = program(
    "// a comment", "jHome={0,-20,95,0,45,0}", "movej(jHome,tMill[1],mCut)",
    "movej(appro(pW[0],{0,0,-30,0,0,0}),tMill[1],mCut)", "movel(pW[0],tMill[1],mCut)",
    "movec(pW[1],pW[2],tMill[1],mCut)", "do5=true", "call grip()", "n=movel(pW[0],tMill[1],mCut)", "waitEndMove()",
    locals_="",
)  # fmt: skip

#: Data, project, start and stop stand beside the program.
SAMPLE = Sample(
    read=ReadSample(
        text=program(
            "pa.trsf={0,0,0,180,0,0}", "m.tvel=10", "p5.trsf={0,0,5,180,0,0}", "movej(p5,t,mAir)", "pa.trsf.x=10",
            "movel(pa,t,m)", "pa.trsf={10,-4,0,180,0,0}", "movel(pa,t,m)", "p5.trsf={10,-4,5,180,0,0}",
            "movej(p5,t,mAir)",
        ),
        pieces="<Program <Code> <![CDATA[ begin end ]]></Code> movel( movej( movec( ) pW[0] , tMill[1] mCut .trsf={ } "
        "= { 1,2, <Value key= /> call grip() if endIf link(pW,world) appro( jHome < > \" &lt;",
        whole=WHOLE,
        beside=(".dtx", DATA),
        refused=(
            *((program(*SET, line, "movel(pa,t,m)"), LINE, words) for line, words in REFUSED),
            *((program(*SET, *lines), LINE + at, words) for lines, at, words in LATER),
            (program(*SET).replace('name="pb"', 'name="pa"'), 11, "pa stands twice"),
        ),
        mistakes=(
            ("  // Program\n  nTraj=movel(p,t,m)\n", "not a VAL3 program"),
            (program("waitEndMove()"), "no move"),
            (program(*SET).replace("\nend\n", "\n"), "begin ... end"),
            (program(*SET).replace("]]></Code>", ""), "cut off"),
            (program(*SET) + "<Program>\n", "two programs in one file"),
        ),
        spelled=(
            (program(*SET, "movel(pa,t,m)").replace("<![CDATA[", "").replace("]]>", ""), (12.5, -3.0, 0.0)),
            (program(*SET, "nId = movel ( pa , flange[0], m )", "if a==1", "x=2", "endIf"), (12.5, -3.0, 0.0)),
            (program(*SET, "movel(appro(pa,{0,0,-40,0,0,0}),t,m)"), (12.5, -3.0, 40.0)),
        ),
    ),
    written=WrittenSample(
        frame=2e-7,
        rapid_speed=True,
        files=5,
        most_lines=5100,
        no_names=("1110_wall", "a-b", "a" * 16, "start", "Stop", "tool", "größe", "a b", "pMove001", "fWork"),
        no_name="is no VAL3 name",
        longest=(15, 11),
    ),
    examples=2,
)
