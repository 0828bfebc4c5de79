"""L5X documents as Studio 5000 prints them, put together from parts."""

from collections.abc import Iterable
from html import escape
from typing import Any

HEAD = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'


def cdata(text: str) -> str:
    return f"<![CDATA[{text}]]>"


def described(text: str) -> str:
    return f"<Description>\n{cdata(text)}\n</Description>\n" if text else ""


def rung(text: str, *, number: int = 0, kind: str = "N", comment: str = "") -> str:
    said = f"<Comment>\n{cdata(comment)}\n</Comment>\n" if comment else ""
    return f'<Rung Number="{number}" Type="{kind}">\n{said}<Text>\n{cdata(text)}\n</Text>\n</Rung>\n'


def ladder(name: str, *rungs: str, use: str = "") -> str:
    """A routine; what is not a <Rung> becomes one."""
    listed = (
        each if each.startswith("<Rung") else rung(each, number=number) for number, each in enumerate(rungs)
    )
    inside = "".join(listed)
    return f'<Routine {use}Name="{name}" Type="RLL">\n<RLLContent>\n{inside}</RLLContent>\n</Routine>\n'


def structured(name: str, text: str) -> str:
    lines = "".join(
        f'<Line Number="{number}">\n{cdata(line)}\n</Line>\n' for number, line in enumerate(text.splitlines())
    )
    return f'<Routine Name="{name}" Type="ST">\n<STContent>\n{lines}</STContent>\n</Routine>\n'


def diagram(name: str, kind: str) -> str:
    """A routine that is refused: a diagram with a block that is not known here, or an empty chart."""
    if kind == "FBD":
        return sheets(name, block("IMC", 0, "Loop"))
    return f'<Routine Name="{name}" Type="{kind}">\n<{kind}Content/>\n</Routine>\n'


def tag(name: str, kind: str, dims: str = "", data: str = "", comment: str = "") -> str:
    length = f' Dimensions="{dims}"' if dims else ""
    inside = described(comment) + (f'<Data Format="Decorated">\n{data}</Data>\n' if data else "")
    return f'<Tag Name="{name}" TagType="Base" DataType="{kind}"{length} Constant="false">\n{inside}</Tag>\n'


def alias(name: str, target: str) -> str:
    return f'<Tag Name="{name}" TagType="Alias" AliasFor="{escape(target)}"/>\n'


def member(
    name: str, kind: str, dim: int = 0, *, target: str = "", bit: int = 0, hidden: bool = False
) -> str:
    packed = f' Target="{target}" BitNumber="{bit}"' if target else ""
    return (
        f'<Member Name="{name}" DataType="{kind}" Dimension="{dim}" Radix="Decimal" '
        f'Hidden="{str(hidden).lower()}"{packed}/>\n'
    )


def data_type(name: str, *members: str, family: str = "NoFamily") -> str:
    inside = f"<Members>\n{''.join(members)}</Members>\n"
    return f'<DataType Name="{name}" Family="{family}" Class="User">\n{inside}</DataType>\n'


def value(kind: str, text: object) -> str:
    return f'<DataValue DataType="{kind}" Value="{text}"/>\n'


def parameter(name: str, kind: str, usage: str, *, required: bool = True, default: str = "") -> str:
    data = f'<DefaultData Format="Decorated">{value(kind, default)}</DefaultData>' if default else ""
    return (
        f'<Parameter Name="{name}" TagType="Base" DataType="{kind}" Usage="{usage}" '
        f'Required="{str(required).lower()}">{data}</Parameter>\n'
    )


def add_on(
    name: str, parameters: Iterable[str], local: Iterable[str] = (), *routines: str, runs: str = ""
) -> str:
    """An add-on instruction; `runs` are attributes such as `ExecutePostscan="true"`."""
    enables = parameter("EnableIn", "BOOL", "Input", required=False)
    enables += parameter("EnableOut", "BOOL", "Output", required=False)
    return (
        f'<AddOnInstructionDefinition Name="{name}" Revision="1.0" {runs}>\n<Parameters>\n{enables}'
        f"{''.join(parameters)}</Parameters>\n<LocalTags>\n{''.join(local)}</LocalTags>\n"
        f"<Routines>\n{''.join(routines)}</Routines>\n</AddOnInstructionDefinition>\n"
    )


def program(name: str, *routines: str, tags: Iterable[str] = (), main: str = "Main", fault: str = "") -> str:
    names = f' MainRoutineName="{main}"' if main else ""
    names += f' FaultRoutineName="{fault}"' if fault else ""
    return (
        f'<Program Name="{name}"{names} Disabled="false">\n<Tags>\n{"".join(tags)}</Tags>\n'
        f"<Routines>\n{''.join(routines)}</Routines>\n</Program>\n"
    )


def task(name: str, *programs: str, kind: str = "CONTINUOUS", rate: float = 0, priority: int = 10) -> str:
    period = f' Rate="{rate}"' if rate else ""
    inside = "".join(f'<ScheduledProgram Name="{each}"/>\n' for each in programs)
    return (
        f'<Task Name="{name}" Type="{kind}"{period} Priority="{priority}" Watchdog="500">\n'
        f"<ScheduledPrograms>\n{inside}</ScheduledPrograms>\n</Task>\n"
    )


def module(name: str, slot: int, *tags: str, parent: str = "Local", catalog: str = "1769-IQ16") -> str:
    inside = "".join(tags)
    return (
        f'<Module Name="{name}" CatalogNumber="{catalog}" Vendor="1" ProductType="7" ProductCode="70" '
        f'ParentModule="{parent}" ParentModPortId="1">\n<Ports>\n'
        f'<Port Id="1" Address="{slot}" Type="Compact" Upstream="true"/>\n</Ports>\n<Communications>\n'
        f'<Connections>\n<Connection Name="Input" RPI="20000" Type="Input">\n{inside}</Connection>\n'
        f"</Connections>\n</Communications>\n</Module>\n"
    )


def document(
    *,
    target: str = "Controller",
    name: str = "Plant",
    types: Iterable[str] = (),
    modules: Iterable[str] = (),
    add_ons: Iterable[str] = (),
    tags: Iterable[str] = (),
    programs: Iterable[str] = (),
    tasks: Iterable[str] = (),
    revision: str = "32.02",
) -> str:
    """A document: a whole controller, or a partial export with another target."""
    use = "Target" if target == "Controller" else "Context"
    groups = (
        ("DataTypes", types),
        ("Modules", modules),
        ("AddOnInstructionDefinitions", add_ons),
        ("Tags", tags),
        ("Programs", programs),
        ("Tasks", tasks),
    )
    inside = "".join(f"<{group}>\n{''.join(parts)}</{group}>\n" for group, parts in groups)
    return (
        f'{HEAD}<RSLogix5000Content SchemaRevision="1.0" SoftwareRevision="{revision}" TargetName="{name}" '
        f'TargetType="{target}" ContainsContext="{str(target != "Controller").lower()}">\n'
        f'<Controller Use="{use}" Name="{name}" ProcessorType="1769-L33ER">\n{inside}'
        f"</Controller>\n</RSLogix5000Content>\n"
    )


def machine(*rungs: str, tags: Iterable[str] = (), **parts: Any) -> str:
    """A whole controller with one program Main with a routine Main."""
    return document(
        tags=tags, programs=[program("Main", ladder("Main", *rungs))], tasks=[task("T", "Main")], **parts
    )


def after(imported: Any, scans: int = 1) -> Any:
    """The tags of an imported controller after scans."""
    for _ in range(scans):
        imported.controller.step()
    return imported.controller.tags


def sheets(name: str, *contents: str) -> str:
    """A routine of function block diagrams, each content a sheet; see `block`, `function`, `wire`."""
    inside = "".join(f'<Sheet Number="{n}">\n{each}</Sheet>\n' for n, each in enumerate(contents, start=1))
    content = (
        f'<FBDContent SheetSize="A - 8.5 x 11 in" SheetOrientation="Landscape">\n{inside}</FBDContent>\n'
    )
    return f'<Routine Name="{name}" Type="FBD">\n{content}</Routine>\n'


def reference(tag: str, key: int, operand: str, *, x: int = 0, y: int = 0) -> str:
    """An IRef or ORef."""
    return f'<{tag} ID="{key}" X="{x}" Y="{y}" Operand="{escape(operand)}" HideDesc="false"/>\n'


def connector(tag: str, key: int, name: str) -> str:
    """An ICon or OCon."""
    return f'<{tag} ID="{key}" X="0" Y="0" Name="{name}"/>\n'


def block(
    kind: str,
    key: int,
    operand: str = "",
    *,
    x: int | str = 0,
    y: int | str = 0,
    pins: str = "",
    **arrays: str,
) -> str:
    """A block with its tag and its arrays by name; without a tag a function, such as `ADD__F`."""
    place = f'ID="{key}" X="{x}" Y="{y}"'
    if not operand:
        return f'<Function Type="{kind}" {place}/>\n'
    inside = "".join(f'<Array Name="{name}" Operand="{each}"/>\n' for name, each in arrays.items())
    head = f'<Block Type="{kind}" {place} Operand="{operand}" VisiblePins="{pins}" HideDesc="false"'
    return f"{head}>\n{inside}</Block>\n" if arrays else f"{head}/>\n"


def wire(start: int | str, end: int | str, *, feedback: bool = False) -> str:
    """A wire from `3.Out` to `4.In1`, or from or to a reference, `3`."""
    source, _, output = str(start).partition(".")
    target, _, pin = str(end).partition(".")
    names = (f' FromParam="{output}"' if output else "", f' ToParam="{pin}"' if pin else "")
    tag = "FeedbackWire" if feedback else "Wire"
    return f'<{tag} FromID="{source}"{names[0]} ToID="{target}"{names[1]}/>\n'
