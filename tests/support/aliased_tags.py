"""An exported controller with tags of each External Access and aliases of all kinds."""

from __future__ import annotations

from pathlib import Path

TAG = '<Tag Name="{0}" TagType="Base" DataType="DINT" ExternalAccess="{1}"/>'
ALIAS = '<Tag Name="{0}" TagType="Alias" AliasFor="{1}" ExternalAccess="Read/Write"/>'
TAGS = "".join(
    [
        TAG.format("Open", "Read/Write"),
        TAG.format("Seen", "Read Only"),
        TAG.format("Hid", "None"),
        '<Tag Name="Row" TagType="Base" DataType="DINT" Dimensions="4" ExternalAccess="Read/Write"/>',
        ALIAS.format("Third", "Row[2]"),
        ALIAS.format("Again", "Third"),
        ALIAS.format("Bit", "Row[2].5"),
        ALIAS.format("Whole", "Row"),
        ALIAS.format("Secret", "Hid"),
        ALIAS.format("Shown", "Seen"),
        ALIAS.format("Own", "Open"),
        ALIAS.format("Stopped", "Local:1:I.Data[0].3"),
        ALIAS.format("Round", "Trip"),
        ALIAS.format("Trip", "Round"),
    ]
)
L5X = f"""<?xml version="1.0" encoding="UTF-8"?>
<RSLogix5000Content SchemaRevision="1.0" TargetType="Controller">
<Controller Name="m" ProcessorType="1769-L33ER">
<Tags>{TAGS}</Tags>
<Programs><Program Name="Main" MainRoutineName="R"><Tags>
{ALIAS.format("Mine", "Row[1]")}
</Tags><Routines><Routine Name="R" Type="RLL"><RLLContent>
<Rung Number="0" Type="N"><Text><![CDATA[MOV(7,Row[2]);]]></Text></Rung>
</RLLContent></Routine></Routines></Program></Programs>
<Tasks><Task Name="T" Type="CONTINUOUS">
<ScheduledPrograms><ScheduledProgram Name="Main"/></ScheduledPrograms></Task></Tasks>
</Controller></RSLogix5000Content>
"""
RACK = """name = "m"
program = "m.L5X"
[server]
writable = ["*"]
profile = "{0}"
[[slot]]
number = 1
module = "amci3601"
"""


def write_aliases(folder: Path, profile: str = "generic") -> Path:
    """Write the controller and its rack file; return the path of that."""
    (folder / "m.L5X").write_text(L5X, "utf-8")
    rack = folder / "m.toml"
    rack.write_text(RACK.format(profile), "utf-8")
    return rack
