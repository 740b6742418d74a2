"""URDF texts for the tests: a two-joint arm and its parts."""

AXIS_Y = '<axis xyz="0 1 0"/>'
LIMIT = '<limit lower="-1" upper="1" effort="10" velocity="2"/>'
SPHERE = {"ixx": 0.1, "ixy": 0, "ixz": 0, "iyy": 0.1, "iyz": 0, "izz": 0.1}


def link(name: str, mass: object = 1, centre: str = "0.1 0 0.2", **inertia: object) -> str:
    """A link; components of the inertia that are not given are a sphere's."""
    components = " ".join(f'{key}="{value}"' for key, value in {**SPHERE, **inertia}.items())
    return (
        f'<link name="{name}"><inertial><origin xyz="{centre}"/>'
        f'<mass value="{mass}"/><inertia {components}/></inertial></link>'
    )


def joint(
    name: str, parent: str, child: str, kind: str = "revolute", inside: str = AXIS_Y + LIMIT
) -> str:
    """A joint half a metre above its parent."""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 0.5"/>{inside}</joint>'
    )


def robot(*parts: str, attributes: str = 'name="arm"') -> str:
    """A robot of parts."""
    return f"<robot {attributes}>{''.join(parts)}</robot>"


BASE = '<link name="base"/>'
SHOULDER = joint("shoulder", "base", "upper")
ELBOW = joint("elbow", "upper", "lower")
LINKS = BASE + link("upper") + link("lower")
TWO_JOINTS = robot(LINKS, SHOULDER, ELBOW)


def with_elbow(inside: str, kind: str = "revolute") -> str:
    """The two-joint arm with other elements inside its elbow."""
    return robot(LINKS, SHOULDER, joint("elbow", "upper", "lower", kind, inside))


def with_upper(upper: str) -> str:
    """The two-joint arm with another upper link."""
    return robot(BASE, upper, link("lower"), SHOULDER, ELBOW)
