"""A small URDF whose controller measures from frames of their own: ``wbase`` and ``fanuc_flange``."""

from __future__ import annotations

_MASS = (120.0, 90.0, 80.0, 30.0, 9.0, 2.0)
_ARM = (  # parent to joint, m; axis
    ("0 0 0.5", "0 0 1"),
    ("0.15 0 0.05", "0 1 0"),
    ("0 0 0.87", "0 -1 0"),
    ("0.3 0 0.17", "-1 0 0"),
    ("0.7 0 0", "0 -1 0"),
    ("0 0 0", "-1 0 0"),
)


def link(name: str, mass: float = 0.0) -> str:
    if not mass:
        return f'<link name="{name}"/>'
    inertia = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    return f'<link name="{name}"><inertial><origin xyz="0.05 0 0.1"/><mass value="{mass}"/>{inertia}</inertial></link>'


def fixed(parent: str, child: str, xyz: str = "0 0 0", rpy: str = "0 0 0") -> str:
    """A link with the joint that welds it to another."""
    ends = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}" rpy="{rpy}"/>'
    return f'{link(child)}<joint name="{parent}-{child}" type="fixed">{ends}</joint>'


def arm(prefix: str = "") -> str:
    """Six axes on ``base_link``, to ``fanuc_flange``; every name with a prefix."""
    out, below = [link(f"{prefix}base_link", 200.0)], f"{prefix}base_link"
    for k, (xyz, axis) in enumerate(_ARM, 1):
        name = f"{prefix}J{k}"
        ends = f'<parent link="{below}"/><child link="{name}_link"/><origin xyz="{xyz}"/><axis xyz="{axis}"/>'
        bounds = '<limit lower="-3.1" upper="3.1" effort="1" velocity="3"/>'
        out.append(f'{link(f"{name}_link", _MASS[k - 1])}<joint name="{name}" type="revolute">{ends}{bounds}</joint>')
        below = f"{name}_link"
    out.append(fixed(below, f"{prefix}fanuc_flange", "0.175 0 0", "3.141592653589793 -1.5707963267948966 0"))
    return "".join(out)


def urdf(*more: str, stand: tuple[str, str] = ("0.1 0.2 0.3", "0 0 0.4")) -> str:
    """The arm on ``world``, with further elements."""
    up = f'<origin xyz="{stand[0]}" rpy="{stand[1]}"/>'
    standing = f'<joint name="stands" type="fixed"><parent link="world"/><child link="base_link"/>{up}</joint>'
    return f'<robot name="framed">{link("world")}{arm()}{standing}{"".join(more)}</robot>'


FRAMED = urdf(fixed("base_link", "wbase", "0 0 0.55", "0 0 1.2"))
