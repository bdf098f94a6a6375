"""Load thousands of files with faults in them: each is read, or refused by an error of the library.

python tools/mutated_files.py {yaml,json,xacro,mjcf,urdf,sdf} [COUNT] [SEED]

Prints how many were read and refused, the longest processor time of one file, and the most memory.
A file that ends otherwise is kept, and named; then the exit code is 1.
"""

from __future__ import annotations

import json
import random
import re
import resource
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from hybrid_dynamics_core.description.located_yaml import read_yaml
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.formats.reader import read_description

ROBOTS = Path(__file__).parent.parent / "hybrid_dynamics_core" / "robots"
XACRO = """\
<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="mass" default="2"/>
  <xacro:property name="n" value="5"/>
  <xacro:property name="length" value="${0.1 * n}"/>
  <xacro:macro name="chain" params="k">
    <link name="l${k}"><inertial><mass value="$(arg mass)"/><origin xyz="${length/2} 0 0"/>
      <inertia ixx="1" iyy="${1 + k}" izz="${1 + k}" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <xacro:if value="${k &gt; 0}">
      <joint name="j${k}" type="revolute"><parent link="l${k-1}"/><child link="l${k}"/>
        <origin xyz="${length} 0 0" rpy="0 ${pi/2} 0"/><axis xyz="0 ${sin(pi/2)} 0"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
      <xacro:chain k="${k-1}"/>
    </xacro:if>
  </xacro:macro>
  <xacro:chain k="${n}"/>
</robot>
"""
MJCF = """\
<mujoco model="r">
  <compiler angle="degree" eulerseq="xyz" autolimits="true"/>
  <option gravity="0 0 -9.81"><flag contact="disable"/></option>
  <default><joint damping="0.1" axis="0 1 0"/><default class="c"><geom type="box" size=".1 .1 .1"/>
  </default></default>
  <asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>
  <worldbody>
    <body name="crank" pos="0 0 0.5"><joint name="a" range="-90 90" ref="10" stiffness="2"/>
      <inertial pos=".1 0 0" mass="1" diaginertia=".001 .0033 .0033"/><site name="s" pos="0 0 .1"/>
      <body name="coupler" pos=".2 0 0" euler="0 0 10"><joint name="b"/><geom class="c"/>
        <frame pos="0 .1 0"><body name="tip"><joint name="d" type="slide"/><geom size=".1"/>
        </body></frame></body></body>
    <body name="rocker" pos=".45 0 0"><joint name="e" armature=".1" frictionloss=".1"/>
      <geom type="mesh" mesh="m"/><site name="t"/></body>
    <body name="ball" pos="1 0 0"><freejoint/><geom size=".2"/></body>
    <replicate count="3" offset="0 1 0"><body><joint/><geom size=".1" mass="1"/></body></replicate>
  </worldbody>
  <tendon><fixed name="f"><joint joint="a" coef="1"/><joint joint="e" coef="2"/></fixed></tendon>
  <equality><connect body1="coupler" body2="rocker" anchor=".5 0 0"/>
    <connect site1="s" site2="t" active="false"/><joint joint1="d" joint2="a" polycoef="0 .2 0"/>
  </equality>
  <actuator><motor joint="a" gear="50" ctrlrange="-1 1"/><position tendon="f" kp="3"/></actuator>
  <keyframe><key name="home" qpos="0 0 0 0 1 0 0 1 0 0 0 0 0 0"/></keyframe>
</mujoco>
"""
WORDS = [
    *("", "0", "-1", "1e999", ".inf", "nan", "[]", "{}", "null", '"', "'", "<", ">", "&a;", "*a"),
    *("!!python/object:x", "9**9**9", "pi", "../", "\0", "\ufeff", "é", "true", "x" * 50, ": "),
    *("- ", "\t", "\n", "#", "quat", "matrix", "xacro:", "name=", "[[[[", "{{{{", "${", "$("),
]
URDF = """\
<robot name="r" version="1.2">
  <link name="a"/>
  <link name="b"><inertial><mass value="2"/><origin xyz="0.1 0 0" rpy="0 0.1 0"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="c"><inertial><mass value="1"/><origin quat_xyzw="0 0 0 1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0.1" ixz="0" iyz="0"/></inertial></link>
  <link name="d"/>
  <joint name="p" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="5" velocity="2"/><dynamics damping="0.1"/></joint>
  <joint name="q" type="continuous"><origin xyz="0.3 0 0"/><parent link="b"/><child link="c"/>
    <axis xyz="0 1 0"/><mimic joint="p" multiplier="2" offset="0.1"/></joint>
  <joint name="s" type="fixed"><parent link="c"/><child link="d"/></joint>
  <joint name="f" type="floating"><parent link="d"/><child link="e"/></joint><link name="e"/>
  <transmission name="t"><joint name="p"/><actuator name="m"/></transmission>
  <ros2_control name="h" type="system"><joint name="p"><command_interface name="effort"/></joint>
  </ros2_control>
  <gazebo reference="b"><gravity>true</gravity></gazebo>
</robot>
"""
_BODY = "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>"
SDF = f"""\
<sdf version="1.9"><world name="w"><gravity>0 0 -9.8</gravity>
  <include><uri>model://ground</uri></include>
  <model name="m" placement_frame="a"><pose relative_to="world">0 0 1 0 0 0.1</pose>
    <frame name="f" attached_to="a"><pose degrees="true">0 0 0 0 0 90</pose></frame>
    <link name="a">{_BODY}</link>
    <link name="b"><pose relative_to="f">0.1 0 0 0 0 0</pose>{_BODY}</link>
    <model name="n"><pose relative_to="b">0 0 0.1 0 0 0</pose>
      <link name="c"><gravity>true</gravity>{_BODY}</link>
      <link name="d"><pose relative_to="c">0.2 0 0 0 0 0</pose>{_BODY}</link>
      <joint name="u" type="universal"><parent>c</parent><child>d</child>
        <axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2></joint></model>
    <joint name="p" type="revolute"><parent>a</parent><child>b</child><axis>
      <xyz expressed_in="f">0 1 0</xyz><limit><lower>-1</lower><upper>1</upper></limit>
      </axis></joint>
    <joint name="k" type="fixed"><parent>b</parent><child>n::c</child></joint>
    <joint name="l" type="ball"><parent>a</parent><child>n::d</child></joint>
    <joint name="g" type="fixed"><parent>world</parent><child>a</child></joint>
  </model></world></sdf>
"""
XML = {"xacro": XACRO, "mjcf": MJCF, "urdf": URDF, "sdf": SDF}
EXPRESSIONS = [
    *("${9**9**9}", "${[0]*10**10}", "${'a'*10**10}", "$(find x)", "${x}", "${load_yaml('x')}"),
    *("${m.k}", "${python.map}", "${1/0}", "${[x for x in range(9)]}", "$(arg q)", "$(eval 1+1)"),
    *("$(dirname)", "$(cwd)", "${", "}", "${{}}", "$$", "${lambda: 1}", "${n", "**b", "k:=1 j:=^"),
    *(
        "${xacro.fatal(1)}",
        "${xacro.message(1)}",
        "${len(x)}",
        "${-k}",
        "${k+1}",
        "true",
        "",
        "a b",
    ),
    *("../x.xacro", "/dev/zero", "r.xacro", "*.xacro", "${(lambda f: f(f))(lambda f: f(f))}"),
    *("${math.factorial(10**7)}", "${max([])}", "$(optenv A b)", "${dict(a=1).a}", "${().real}"),
]
LARGE = ["", "0", "-1", "1e308", "nan", "9" * 9, "1 2", "a", "b", "s", "../x.xml", "/dev/zero"]
NUMBERS = ["0", "-1", "1e300", "1e-300", "99999999999", "nan", ".inf", "[1,2]", "abc"]


def texts(form: str) -> list[str]:
    """Files that are right."""
    if form in XML:
        return [XML[form]]
    robots = [file.read_text(encoding="utf-8") for file in sorted(ROBOTS.glob("*.yaml"))]
    if form == "yaml":
        return robots
    return [json.dumps(read_yaml(text).data, indent=1) for text in robots]


class Mutation:
    """Makes faults: some in letters, some in numbers, words, lines and attributes."""

    def __init__(self, form: str, seed: int) -> None:
        self.random = random.Random(seed)  # noqa: S311 - no secret
        self.kinds = [self.letters, self.number, self.word, self.lines]
        self.values = EXPRESSIONS if form == "xacro" else LARGE
        if form in XML:  # the most of letters would be no XML
            self.kinds = [self.number, self.word, self.attribute, self.attribute, self.attribute]

    def changed(self, text: str) -> str:
        """The text with one to four faults."""
        for _ in range(self.random.randint(1, 4)):
            text = self.random.choice(self.kinds)(text) or " "
        return text

    def letters(self, text: str) -> str:
        """Letters that are left out, replaced or repeated."""
        start = self.random.randrange(len(text) + 1)
        end = min(len(text), start + self.random.choice([0, 1, 2, 5, 20, 100, 400]))
        new = self.random.choice([self.random.choice(WORDS), text[start:end] * 50])
        return text[:start] + new + text[end:]

    def number(self, text: str) -> str:
        """Another number."""
        return self.replaced(text, r"-?\d+\.?\d*", NUMBERS)

    def word(self, text: str) -> str:
        """Another word of the text."""
        words = re.findall(r"\w+", text) or [" "]
        return self.replaced(text, r"\w+", words)

    def attribute(self, text: str) -> str:
        """Another value of an attribute."""
        return self.replaced(text, r'(?<==")[^"]*(?=")', self.values)

    def replaced(self, text: str, pattern: str, choices: list[str]) -> str:
        """One of the places that match, with one of the choices."""
        matches = list(re.finditer(pattern, text))
        if not matches:
            return text
        match = self.random.choice(matches)
        return text[: match.start()] + self.random.choice(choices) + text[match.end() :]

    def lines(self, text: str) -> str:
        """Two lines in each other's place."""
        lines = text.split("\n")
        one, other = (self.random.randrange(len(lines)) for _ in range(2))
        lines[one], lines[other] = lines[other], lines[one]
        return "\n".join(lines)


def outcome(file: Path) -> str:
    """What comes of a file."""
    try:
        read_description(file)
    except HybridDynamicsError:
        return "refused"
    except Exception as error:  # noqa: BLE001 - which is what is looked for
        return f"{type(error).__name__}: {error}"
    return "read"


def processor_time() -> float:
    """Processor time of this process and of those that it started and that have ended [s]."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + ended.ru_utime + ended.ru_stime


def main(form: str, count: int = 2000, seed: int = 0) -> int:
    """Load the files of one format."""
    right = texts(form)
    mutation = Mutation(form, seed)
    counts: Counter[str] = Counter()
    longest = 0.0
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"r.{form}"
        for k in range(count):
            text = mutation.changed(mutation.random.choice(right))
            file.write_text(text, encoding="utf-8", errors="surrogatepass")
            start = processor_time()
            result = outcome(file)
            longest = max(longest, processor_time() - start)
            counts[result] += 1
            if result not in ("read", "refused"):
                kept = Path(tempfile.gettempdir()) / f"mutated_{seed}_{k}.{form}"
                kept.write_text(text, encoding="utf-8", errors="surrogatepass")
                print(f"{kept}: {result}")
    usages = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    memory = max(resource.getrusage(usage).ru_maxrss for usage in usages) / 1024.0
    print(f"{form}: {dict(counts)}; longest {longest:.2f} s, most memory {memory:.0f} MB")
    return int(bool(set(counts) - {"read", "refused"}))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], *map(int, sys.argv[2:])))
