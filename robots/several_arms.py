#!/usr/bin/env python3
"""Writes robots of several Kinova Gen3 side by side: copies of kinova_gen3/kinova_gen3.urdf on one base.

    python3 robots/several_arms.py          # writes kinova_gen3_2arms and kinova_gen3_3arms
    python3 robots/several_arms.py --check  # exit code 1 if a file is not what would be written

Links and joints of arm k get the prefix arm_k_. Their bases stand along y, APART metres from each other, so arms may
meet: nothing in the scenarios keeps them clear of each other.
"""

import re
import sys
from pathlib import Path

APART = 1.0
FOLDER = Path(__file__).parent
SINGLE = FOLDER / "kinova_gen3" / "kinova_gen3.urdf"


def arms(count: int) -> str:
    """The URDF of so many arms."""
    text = SINGLE.read_text()
    body = re.search(r'<robot name="kinova_gen3">\n(.*)</robot>', text, re.DOTALL).group(1)
    parts = [
        '<?xml version="1.0"?>\n',
        f"<!-- {count} Kinova Gen3, {APART} m apart: written by robots/several_arms.py. "
        "Figures: see robots/SOURCES.md. -->\n",
        f'<robot name="kinova_gen3_{count}arms">\n',
        '  <link name="base"/>\n',
    ]
    for k in range(count):
        arm = f"arm_{k + 1}_"
        y = APART * (k - (count - 1) / 2)
        parts += [
            f'  <joint name="{arm}base" type="fixed">\n',
            f'    <origin xyz="0 {y:g} 0" rpy="0 0 0"/>\n',
            '    <parent link="base"/>\n',
            f'    <child link="{arm}base_link"/>\n',
            "  </joint>\n",
            re.sub(r'( name| link)="', rf'\1="{arm}', body),
        ]
    return "".join(parts) + "</robot>\n"


def main() -> int:
    stale = 0
    for count in (2, 3):
        name = f"kinova_gen3_{count}arms"
        path = FOLDER / name / f"{name}.urdf"
        if "--check" in sys.argv[1:]:
            if path.read_text() != arms(count):
                print(f"{path} is not what this script writes", file=sys.stderr)
                stale = 1
        else:
            path.parent.mkdir(exist_ok=True)
            path.write_text(arms(count))
    return stale


if __name__ == "__main__":
    sys.exit(main())
