"""The six arms on which every law is tested."""

import numpy as np

from ftcfa import load_arm

GANTRY = """<robot name="gantry"><link name="rail"/>
<link name="trolley"><inertial><origin xyz="0 0.1 0"/><mass value="5"/>
  <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<link name="rod"><inertial><origin xyz="0.02 0 -0.4"/><mass value="1.5"/>
  <inertia ixx="0.08" ixy="0.001" ixz="0" iyy="0.09" iyz="0" izz="0.03"/></inertial></link>
<link name="hook"><inertial><origin xyz="0 0 -0.1"/><mass value="0.7"/>
  <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
<joint name="slide" type="prismatic"><parent link="rail"/><child link="trolley"/>
  <axis xyz="1 0.2 0"/><limit lower="-3" upper="3" effort="80" velocity="2"/>
  <dynamics damping="1.5" friction="0.5"/></joint>
<joint name="swing" type="revolute"><parent link="trolley"/><child link="rod"/>
  <axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="40" velocity="4"/></joint>
<joint name="hoist" type="prismatic"><parent link="rod"/><child link="hook"/>
  <origin xyz="0 0 -0.8" rpy="0.1 0 0.3"/><axis xyz="0 0 -1"/>
  <limit lower="-1" upper="1" effort="60" velocity="2"/></joint>
</robot>"""
"""A trolley on a rail, a rod that swings below it and a hook that slides along the rod."""

ARMS = ("double_pendulum", "panda", "ur5", "xarm7", "so101", "gantry")


def arm_of(name, folder):
    """An arm by its name; the gantry's URDF is written into the folder."""
    if name != "gantry":
        return load_arm(name)
    file = folder / "gantry.urdf"
    file.write_text(GANTRY)
    return load_arm(str(file))


class Mass:
    """A unit mass on a rail."""

    n = 1
    effort_limit = np.array([100.0])

    def mass_matrix(self, q):
        return np.eye(1)

    def bias_force(self, q, v):
        return np.zeros(1)

    def damping_matrix(self, v):
        return np.zeros((1, 1))
