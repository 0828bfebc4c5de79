#!/usr/bin/env bash
# what: l5x reads a tag only in the radix Decimal: Hex raises, is written without its base, and a LINT is an empty dictionary
# date: 2026-11-30
# meets: anyone who edits presets of a Logix project with a script
# expected: 255, 6 and 5000000000, and 16#0000_0010 after 16 is assigned to a tag in hexadecimal
# behavior:
#   The value of an integer is int(text), so `16#0000_00ff` and `2#0000_0110` raise ValueError. Assigning to such a tag
#   works: its text becomes 16 beside Radix="Hex". LINT is not among the package's base types; it is taken for a
#   structure without members.
# product: Reads and keeps every radix: [L5X](l5x.md)
# output:
#   Hex ValueError invalid literal for int() with base 10: '16#0000_00ff'
#   Binary ValueError invalid literal for int() with base 10: '2#0000_0110'
#   Long {}
#   <DataValue DataType="DINT" Radix="Hex" Value="16" />
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install l5x==1.7
observe python - <<'PY'
import re
from pathlib import Path

import l5x


def tag(name, data_type, radix, number, text):
    return f"""<Tag Name="{name}" TagType="Base" DataType="{data_type}" Radix="{radix}" Constant="false"
ExternalAccess="Read/Write"><Data Format="L5K"><![CDATA[{number}]]></Data><Data Format="Decorated">
<DataValue DataType="{data_type}" Radix="{radix}" Value="{text}"/></Data></Tag>"""


Path("project.L5X").write_text(f"""<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<RSLogix5000Content SchemaRevision="1.0" SoftwareRevision="32.00" TargetName="P" TargetType="Controller"
ContainsContext="false" ExportOptions="DecoratedData ForceProtectedEncoding AllProjDocTrans">
<Controller Use="Target" Name="P" ProcessorType="1769-L24ER-QB1B" MajorRev="32" MinorRev="11">
<DataTypes/><Modules/><AddOnInstructionDefinitions/><Tags>
{tag("Hex", "DINT", "Hex", 255, "16#0000_00ff")}
{tag("Binary", "SINT", "Binary", 6, "2#0000_0110")}
{tag("Long", "LINT", "Decimal", 5000000000, "5000000000")}
</Tags><Programs/><Tasks/></Controller></RSLogix5000Content>""")
project = l5x.Project("project.L5X")
tags = project.controller.tags
for name in ("Hex", "Binary", "Long"):
    try:
        print(name, tags[name].value)
    except ValueError as error:
        print(name, "ValueError", error)
tags["Hex"].value = 16
project.write("project.L5X")
print(re.search("<DataValue .*Hex.*?/>", Path("project.L5X").read_text())[0])
PY
