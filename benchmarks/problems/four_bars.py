"""The description of a row of N four-bars, A02 of the IFToMM library."""

from __future__ import annotations

HEAD = """\
# A02 of the IFToMM library: {count} four-bars in a row, all bars 1 m and 1 kg, upright at first.
# As parallelograms the loops are regular also where all bars lie in one line.
format: 1
name: four_bars_{count}
source: IFToMM library A02; lim.ii.udc.es/mbsbenchmark, A02_specification
gravity: [0, -9.81, 0]
links:
  base: {{}}
"""
CRANK = "mass: 1, com: [0, 0.5, 0], inertia: {xx: 1/12, yy: 0, zz: 1/12}"
COUPLER = "mass: 1, com: [0.5, 0, 0], inertia: {xx: 0, yy: 1/12, zz: 1/12}"


def four_bars(count: int) -> str:
    """The description of `count` four-bars, as the text of its file."""
    lines = [HEAD.format(count=count)]
    cranks = range(count + 1)
    couplers = range(1, count + 1)
    lines += [f"  crank_{k}: {{{CRANK}}}\n" for k in cranks]
    lines += [f"  coupler_{k}: {{{COUPLER}}}\n" for k in couplers]
    lines.append("joints:\n")
    lines += [_joint(f"a{k}", "base", f"crank_{k}", f"[{k}, 0, 0]") for k in cranks]
    lines += [_joint(f"b{k}", f"crank_{k - 1}", f"coupler_{k}", "[0, 1, 0]") for k in couplers]
    lines.append("closures:\n")
    for k in couplers:
        ends = f"{{coupler_{k}: [1, 0, 0], crank_{k}: [0, 1, 0]}}"
        words = "kind: planar, assembly: parallelogram"
        lines.append(f"  pin_{k}: {{{words}, between: {ends}}}\n")
    lines.append("active: [a0]\n")
    lines.append("end_effector: {link: crank_0, xyz: [0, 1, 0]}  # point B0\n")
    lines.append("reference: {a0: 0}\n")
    return "".join(lines)


def _joint(name: str, parent: str, child: str, place: str) -> str:
    links = f"parent: {parent}, child: {child}"
    return f"  {name}: {{type: revolute, {links}, axis: z, origin: {{xyz: {place}}}}}\n"
