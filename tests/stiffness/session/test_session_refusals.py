"""What breaks the contract of a session is refused, by file, row, column and value."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stiffness.session.session import load_session
from stiffness.session.table import SessionError
from tests.plant import Arm, Plant, lab
from tests.stiffness.session_desk import QUIET, ROBOT, TARGETS, Rows, write


@pytest.fixture(scope="module")
def day(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str]:
    """Text of session.toml and samples.csv of a session that is in order."""
    folder = tmp_path_factory.mktemp("day")
    form = lab.Form(seconds=9.0, step=True, purposes={2: {"purpose": "joint-4", "points": {"A": "tcp", "B": "side"}}})
    design = {"count": 3, "directions": 1, "pulls": (None, "elbow"), "payload": 1.0}
    write(folder, form=form, design=design, noise=lab.Noise())
    return (folder / "session.toml").read_text(), (folder / "samples.csv").read_text()


@pytest.fixture
def desk(tmp_path: Path, day: tuple[str, str]) -> Path:
    (tmp_path / "session.toml").write_text(day[0])
    (tmp_path / "samples.csv").write_text(day[1])
    return tmp_path


def message(path: Path) -> str:
    with pytest.raises(SessionError) as caught:
        load_session(path)
    text = str(caught.value)
    assert "\n" not in text
    return text


def test_the_day_is_in_order(desk: Path) -> None:
    session = load_session(desk / "session.toml")
    assert len(session.samples) == 36
    assert (session.purposes[2].joint, session.purposes[2].points) == (4, {"A": 0, "B": 2})


CELLS: list[tuple[int, str, str, str]] = [
    (5, "x", "12;3", "not a number"),
    (5, "x", "12,3", "with a point"),
    (5, "y", "nan", "not a finite"),
    (5, "z", "-inf", "not a finite"),
    (5, "z", "", "empty"),
    (5, "z", "1_0", "without '_'"),
    (7, "setup", "1.5", "an integer"),
    (7, "state", "one", "not a number"),
    (7, "state", "-1", "0 (the reference)"),
    (9, "q2", "400", "limits -360 ... 360 deg of joint 2"),
    (9, "q2", "1.25", "one set-up is one commanded configuration"),
    (9, "reflector", "tpc", "did you mean tcp?"),
    (9, "reflector", "", "no such reflector"),
    (9, "approach3", "2", "-1, 0 (unknown) or 1"),
    (9, "approach3", "0", "one set-up is one"),
    (9, "step3", "0.001", "one set-up is one"),
    (9, "time", "noon", "not a number"),
    (9, "payload", "-1", "not negative"),
    (9, "payload", "2", "one state is one load"),
    (20, "load_link", "7", "links 0 ... 6"),
    (20, "load_link", "x", "not a number"),
    (21, "load_link", "2", "row 20 has '3'; one state is one load"),
    (20, "load_link", "", "load_link is empty"),
    (20, "load_at", "elbo", "did you mean elbow?"),
    (20, "fx", "", "empty"),
]


@pytest.mark.parametrize(("line", "column", "cell", "why"), CELLS)
def test_a_wrong_cell_is_named(desk: Path, line: int, column: str, cell: str, why: str) -> None:
    rows = Rows(desk)
    rows.order[line - 2][column] = cell
    text = message(rows.write())
    named = "load_at" if why == "load_link is empty" else column
    assert f"{desk / 'samples.csv'}: row {line}, column {named} = " in text
    assert repr(rows.order[line - 2][named]) in text
    assert why in text


def test_step_against_approach(desk: Path) -> None:
    rows = Rows(desk)
    for row in rows.order[:12]:
        row["step4"] = str(-float(row["step4"]))
    text = message(rows.write())
    assert "row 2, column approach4" in text and "opposite sign" in text and "and 11 more rows" in text


def test_the_last_digit_of_a_display_is_no_other_configuration(desk: Path) -> None:
    rows = Rows(desk)
    first = float(rows.order[0]["q2"])
    rows.order[1]["q2"] = str(first + 5e-5)
    assert len(load_session(rows.write()).samples) == 36
    rows.order[1]["q2"] = str(first + 2e-4)
    assert "row 3, column q2" in message(rows.write())


def test_limits_are_rounded(desk: Path) -> None:
    rows = Rows(desk)
    assert "row 2, column q6 = '360.1': outside the limits" in message(spoil_q6(rows, "360.1"))
    assert load_session(spoil_q6(rows, "360.01")).samples.q[0, 5] == pytest.approx(np.radians(360.01))


def spoil_q6(rows: Rows, cell: str) -> Path:
    """The first set-up turned about the tool axis: the median of all readings stays where it was."""
    for row in rows.order[:12]:
        row["q6"] = cell
    return rows.write()


def test_degrees_in_a_file_of_radians(desk: Path) -> None:
    spoil(desk, 'angle = "deg"', 'angle = "rad"')
    text = message(desk / "session.toml")
    assert "row 2, column q" in text and "these look like degrees: correct units.angle" in text


def spoil(desk: Path, old: str, new: str, name: str = "session.toml") -> Path:
    text = (desk / name).read_text()
    assert old in text
    (desk / name).write_text(text.replace(old, new, 1))
    return desk / "session.toml"


def test_radians_in_a_file_of_degrees_show_in_the_readings(tmp_path: Path) -> None:
    write(tmp_path, form=lab.Form(angle="rad", about="flange"))
    text = message(spoil(tmp_path, 'angle = "rad"', 'angle = "deg"'))
    assert "fit with units.angle = 'rad'" in text and "columns x y z" in text


def test_metres_taken_for_millimetres(tmp_path: Path) -> None:
    write(tmp_path, form=lab.Form(length="m", registered=False))
    assert "fit with units.length = 'm'" in message(spoil(tmp_path, 'length = "m"', 'length = "mm"'))


def test_millimetres_taken_for_metres(desk: Path) -> None:
    spoil(desk, 'length = "mm"', 'length = "m"')
    assert "instruments.tracker = 0.02: in m that is more than 10 mm" in message(desk / "session.toml")
    spoil(desk, "tracker = 0.02", "tracker = 0.00002")
    assert "more than 50 m away; is units.length = 'm' right?" in message(desk / "session.toml")


def test_another_robot(desk: Path) -> None:
    text = message(spoil(desk, 'robot = "ur10"', 'robot = "kuka-kr210-r2700"'))
    assert "column q5 = '-143" in text and "outside the limits -125 ... 125 deg of joint 5" in text
    assert "is it the kuka-kr210-r2700?" in text


def test_another_robot_within_its_limits(tmp_path: Path) -> None:
    arm = Arm.load(ROBOT)
    setups = [
        lab.Setup(np.array([0.3, 0.3 * k - 0.6, -0.4 * k, 0.2 - k / 5, 0.5, k / 2.0]), [0.1] * 6) for k in range(4)
    ]
    notes = lab.measure(Plant(arm, stiffness=1e5), setups, TARGETS, noise=QUIET)
    path = notes.write(tmp_path, "ur10")
    load_session(path)
    text = message(spoil(tmp_path, 'robot = "ur10"', 'robot = "abb-irb6600-175-255"'))
    assert "do not fit robot abb-irb6600-175-255" in text
    assert "are robot, base and tip those that were measured?" in text


def test_unregistered_called_registered(tmp_path: Path) -> None:
    write(tmp_path, form=lab.Form(registered=False))
    assert "fit with registered = false" in message(spoil(tmp_path, "registered = false", "registered = true"))


def test_a_wrong_reading_does_not_refuse_the_session(tmp_path: Path) -> None:
    session, notes = write(tmp_path, form=lab.Form(wrong=5, registered=False), design={"count": 10})
    assert len(notes.truth.wrong_rows) == 5
    assert len(session.samples) == 150


TEXTS: list[tuple[str, str, str]] = [
    ('schema = "measurement-session/1"', 'schema = "measurement-session/2"', "schema = 'measurement-session/2'"),
    ('schema = "measurement-session/1"', "", "key schema is missing"),
    ('robot = "ur10"', 'robot = "ur11"', "robot = 'ur11'"),
    ('robot = "ur10"', 'robot = "there.toml"', "robot = 'there.toml'"),
    ('robot = "ur10"', 'robot = "ur10"\nbase = "world"', "base"),
    ("registered = true", 'registered = "yes"', "registered = 'yes'"),
    ("registered = true", "regsitered = true", "unknown key regsitered; did you mean registered?"),
    ('gravity = "uncompensated"', 'gravity = "off"', "gravity = 'off'"),
    ('length = "mm"', 'length = "inch"', "units.length = 'inch'"),
    ('angle = "deg"', 'angle = "degrees"', "units.angle = 'degrees'"),
    ('angle = "deg"', "", "key units.angle is missing"),
    ('frame = "base"', 'frame = "world"', "wrench.frame = 'world'"),
    ('about = "tcp"', 'about = "sensor"', "wrench.about = 'sensor'"),
    ("tracker = 0.02", "tracker = 0.0", "instruments.tracker = 0.0"),
    ("tracker = 0.02", "tracker = -0.02", "instruments.tracker = -0.02"),
    ("tracker = 0.02", "", "key instruments.tracker is missing"),
    ("force = 0.3", "", "key instruments.force is missing"),
    ("force = 0.3", "force = -0.3", "instruments.force = -0.3"),
    ("force = 0.3", "force = nan", "instruments.force = nan"),
    ("tracker = 0.02", 'tracker = "0.02"', "instruments.tracker = '0.02'"),
    ("mass = 2.5", "mass = -2.5", "tool.mass = -2.5"),
    ("mass = 2.5", "weight = 2.5", "unknown key tool.weight"),
    ("exact = true", "exact = 1", "reflectors.tcp.exact = 1"),
    ("link = 6", "link = 7", "reflectors.tcp.link = 7"),
    ("link = 6", "link = 1.5", "reflectors.tcp.link = 1.5"),
    ("exact = true", 'exact = true\ngroup = "p"', "reflectors.tcp"),
    ("[reflectors.elbow]", "[reflectors.elbow.more]", "unknown key reflectors.elbow.more"),
    ('purpose = "joint-4"', 'purpose = "joint-7"', "setups.2.purpose = 'joint-7'"),
    ('purpose = "joint-4"', 'purpose = "wrist"', "setups.2.purpose = 'wrist'"),
    ("[setups.2]", "[setups.two]", "[setups.two]"),
    ('A = "tcp"', 'A = "tip"', "setups.2.points.A = 'tip'"),
    ('A = "tcp"', 'D = "tcp"', "setups.2.points.D"),
    ('samples = "samples.csv"', 'samples = "sample.csv"', "samples = 'sample.csv': there is no such file"),
    ("[units]", "[units", "is not TOML"),
]


@pytest.mark.parametrize(("old", "new", "why"), TEXTS)
def test_a_wrong_key_is_named(desk: Path, old: str, new: str, why: str) -> None:
    if "group" in new:  # a group whose members sit on two links
        spoil(desk, "link = 3", 'link = 3\ngroup = "p"')
        why = "reflectors.elbow.link = 3: tcp of the same group 'p' has 6"
    text = message(spoil(desk, old, new))
    assert text.startswith(str(desk / "session.toml"))
    assert why in text


def without(name: str) -> Callable[[list[dict[str, str]]], None]:
    def change(rows: list[dict[str, str]]) -> None:
        for row in rows:
            del row[name]

    return change


def added(name: str, cell: str = "0") -> Callable[[list[dict[str, str]]], None]:
    def change(rows: list[dict[str, str]]) -> None:
        for row in rows:
            row[name] = cell

    return change


def renamed(old: str, new: str) -> Callable[[list[dict[str, str]]], None]:
    def change(rows: list[dict[str, str]]) -> None:
        for row in rows:
            row[new] = row.pop(old)

    return change


COLUMNS: list[tuple[Callable[[list[dict[str, str]]], None], str]] = [
    (without("q3"), "column q3 missing"),
    (without("reflector"), "column reflector missing"),
    (renamed("setup", "set_up"), "column setup missing; did you mean set_up?"),
    (without("z"), "column z missing"),
    (without("mz"), "column mz missing beside fx, fy, fz, mx, my"),
    (without("approach6"), "column approach6 missing beside"),
    (without("load_link"), "column load_at without load_link"),
    (added("sx", "0.02"), "column sy, sz missing beside sx"),
    (added("q7"), "column q7: robot ur10 has 6 joints"),
    (added("approach7"), "column approach7: robot ur10 has 6 joints"),
    (renamed("fx", "Fx"), "column Fx: write fx"),
    (added("temperature", "293.15"), "row 2, column temperature = '293.15'"),
    (added("block", "a"), "row 2, column block = 'a'"),
    (added("repeat", "0.5"), "row 2, column repeat = '0.5'"),
]


@pytest.mark.parametrize(("change", "why"), COLUMNS)
def test_a_wrong_column_is_named(desk: Path, change: Callable[[list[dict[str, str]]], None], why: str) -> None:
    rows = Rows(desk)
    change(rows.order)
    text = message(rows.write())
    assert text.startswith(str(desk / "samples.csv")) and why in text


def test_noise_of_a_reading_is_above_zero(desk: Path) -> None:
    rows = Rows(desk)
    for name in ("sx", "sy", "sz"):
        added(name, "0.03")(rows.order)
    rows.order[4]["sy"] = "0"
    assert "row 6, column sy = '0': a standard deviation is above zero, in mm" in message(rows.write())
    rows.order[4]["sy"] = "0.05"
    sd = load_session(rows.write()).samples.sd
    assert sd[4].tolist() == pytest.approx([3e-5, 5e-5, 3e-5])


def test_wrench_and_its_table_belong_together(desk: Path) -> None:
    rows = Rows(desk)
    spoil(desk, '[wrench]\nframe = "base"\nabout = "tcp"\n', "")
    assert "samples.csv: column fx" in message(desk / "session.toml")
    for name in ("fx", "fy", "fz", "mx", "my", "mz"):
        without(name)(rows.order)
    assert "column load_link: no load to place" in message(rows.write())
    for name in ("load_link", "load_at"):
        without(name)(rows.order)
    assert not load_session(rows.write()).samples.load.wrench.any()
    (desk / "session.toml").write_text((desk / "session.toml").read_text() + '[wrench]\nframe="base"\nabout="tcp"\n')
    without("payload")(rows.order)
    assert "[wrench], and" in message(rows.write())


def test_what_a_tool_is_needed_for(desk: Path) -> None:
    text = (desk / "session.toml").read_text()
    start, end = text.index("[tool]"), text.index("[reflectors.")
    (desk / "session.toml").write_text(text[:start] + text[end:])
    assert "column payload" in message(desk / "session.toml")
    rows = Rows(desk)
    without("payload")(rows.order)
    assert "frame = 'base', about = 'tcp', and there is no [tool]" in message(rows.write())
    spoil(desk, 'about = "tcp"', 'about = "flange"')
    session = load_session(desk / "session.toml")
    assert session.tool.mass is None and not session.tool.position.any()
    np.testing.assert_array_equal(session.tool.rotation, np.eye(3))
    assert not session.samples.load.point[0].any()


def test_tool_mass_without_com(desk: Path) -> None:
    text = (desk / "session.toml").read_text()
    start = text.index("com = [")
    (desk / "session.toml").write_text(text[:start] + text[text.index("]", start) + 1 :])
    assert "tool" in (told := message(desk / "session.toml")) and "mass without com" in told


def test_gravity_needs_masses(desk: Path) -> None:
    text = "\n".join(line for line in ROBOT.read_text().splitlines() if not line.startswith(("mass", "com")))
    (desk / "bare.toml").write_text(text.replace('name = "ur10"', 'name = "bare"'))
    told = message(spoil(desk, 'robot = "ur10"', 'robot = "bare.toml"'))
    assert "gravity = 'uncompensated' needs the masses of the links" in told and "gives no masses" in told
    spoil(desk, 'gravity = "uncompensated"', 'gravity = "calibrated-out"')
    assert load_session(desk / "session.toml").gravity == "calibrated-out"


def test_flange_of_a_builtin_robot_by_its_makers_name(desk: Path) -> None:
    session = load_session(spoil(desk, 'robot = "ur10"', 'robot = "ur10"\ntip = "tool0"'))
    assert session.tip == "tool0"


def test_setup_without_reference(desk: Path) -> None:
    rows = Rows(desk)
    rows.order = [r for r in rows.order if (r["setup"], r["state"]) != ("2", "0")]
    text = message(rows.write())
    assert "row 14, column setup = '2': set-up 2 has no reading of state 0" in text and "and 8 more rows" in text


def test_duplicate_rows(desk: Path) -> None:
    rows = Rows(desk)
    rows.order.append(dict(rows.order[3]))
    assert "row 38, column reflector = 'tcp': row 5 reads it in the same set-up and state" in message(rows.write())
    added("repeat", "0")(rows.order)
    assert "number repeats differently" in message(rows.write())
    rows.order[-1]["repeat"] = "1"
    assert len(load_session(rows.write()).samples) == 37


def test_groups_that_are_not_rigid(desk: Path) -> None:
    spoil(desk, "exact = true", 'exact = true\ngroup = "probe"')
    text = message(spoil(desk, "exact = false", 'exact = false\ngroup = "probe"'))
    assert "reflectors.side.exact = false: tcp of the same group 'probe' has true" in text


def test_a_group_counts_once(desk: Path) -> None:
    spoil(desk, "exact = true", 'exact = true\ngroup = "probe"')
    session = load_session(spoil(desk, "exact = false", 'exact = true\ngroup = "probe"'))
    assert session.group.tolist() == [0, -1, 0]
    assert session.counts.reshape(-1, 3).all(axis=0).tolist() == [True, True, False]


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda b: b"", "the first line is empty"),
        (lambda b: b.split(b"\n")[0] + b"\n", "no row below the header"),
        (lambda b: b.replace(b",", b";"), "row 1: cells are separated by semicolons"),
        (lambda b: b.replace(b",", b"\t"), "row 1: cells are separated by tabs"),
        (lambda b: b.replace(b"setup", b"set\xfcp", 1), "row 1: byte 0xfc is not UTF-8"),
        (lambda b: b.replace(b"elbow", b"\xe9lbow", 1), "row 3: byte 0xe9 is not UTF-8"),
        (lambda b: b.replace(b"\n", b",1\n").replace(b",1\n", b"\n", 4), "row 5: "),
        (lambda b: b.replace(b"q2", b"q1", 1), "column q1 stands there twice"),
        (lambda b: b.replace(b"q2", b"", 1), "has no name"),
        (lambda b: b.replace(b"elbow", b'"elbow', 1), "not csv"),
    ],
)
def test_a_file_that_is_no_table(desk: Path, change: Callable[[bytes], bytes], why: str) -> None:
    path = desk / "samples.csv"
    path.write_bytes(change(path.read_bytes()))
    text = message(desk / "session.toml")
    assert text.startswith(str(path)) and why in text


@pytest.mark.parametrize(
    "change",
    [
        lambda b: b"\xef\xbb\xbf" + b,
        lambda b: b.replace(b"\n", b"\r\n"),
        lambda b: b.replace(b"\n", b"\r"),
        lambda b: b.replace(b",", b" , "),
        lambda b: b + b"\n\n",
        lambda b: b.replace(b"tcp", b'"tcp"'),
    ],
)
def test_harmless_differences_of_text(desk: Path, change: Callable[[bytes], bytes]) -> None:
    before = load_session(desk / "session.toml").samples
    for name in ("samples.csv", "session.toml"):
        raw = (desk / name).read_bytes()
        if name == "samples.csv" or change(b"\n") in (b"\r\n", b"\xef\xbb\xbf\n"):
            (desk / name).write_bytes(change(raw))
    after = load_session(desk / "session.toml").samples
    np.testing.assert_array_equal(after.position, before.position)
    np.testing.assert_array_equal(after.line, before.line)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    assert "session.toml: there is no such file" in message(tmp_path / "session.toml")


def test_line_numbers_count_blank_lines(desk: Path) -> None:
    lines = (desk / "samples.csv").read_text().splitlines()
    lines.insert(4, "")
    lines[10] = lines[10].replace(lines[10].split(",")[0], "x", 1)
    (desk / "samples.csv").write_text("\n".join(lines))
    assert "row 11, column setup = 'x'" in message(desk / "session.toml")
