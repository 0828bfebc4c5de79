"""Reports of a check for other programs: SARIF 2.1.0 and JUnit XML."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote
from xml.sax.saxutils import escape, quoteattr

from .check import CheckReport, Finding
from .rules import RULES

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
PAGE = "docs/check-rules.md"


def as_json(report: CheckReport) -> dict[str, object]:
    """Return the report as `--json` prints it."""
    return {
        "findings": [_finding(finding) for finding in report.findings],
        "ignored": report.ignored,
        "not_seen": report.not_seen,
    }


def _finding(each: Finding) -> dict[str, object]:
    row: dict[str, object] = {
        "rule": each.rule,
        "level": each.row.level,
        "file": each.place.file,
        "line": each.place.line,
        "text": each.text,
        "remedy": each.row.remedy,
    }
    if each.site.rung is not None:
        number = "routine_line" if each.site.unit == "line" else each.site.unit
        row |= {"routine": each.site.routine, number: each.site.rung}
    return row


def as_sarif(report: CheckReport, version: str) -> dict[str, object]:
    """Return the report as SARIF 2.1.0 [OASIS, Static Analysis Results Interchange Format, section 3].

    Args:
        version: version of scanrack.
    """
    numbers = {rule.id: number for number, rule in enumerate(RULES)}
    rules = [
        {
            "id": rule.id,
            "shortDescription": {"text": rule.words},
            "help": {"text": f"{rule.remedy} ({PAGE}#{rule.id})"},
            "defaultConfiguration": {"level": rule.level},
        }
        for rule in RULES
    ]
    driver = {"name": "scanrack check", "version": version, "rules": rules}
    results = [
        {
            "ruleId": finding.rule,
            "ruleIndex": numbers[finding.rule],
            "level": finding.row.level,
            "message": {"text": f"{finding.text}; {finding.row.remedy}"},
            "locations": [_location(finding)],
        }
        for finding in report.findings
    ]
    return {"$schema": SCHEMA, "version": "2.1.0", "runs": [{"tool": {"driver": driver}, "results": results}]}


def _location(each: Finding) -> dict[str, object]:
    location: dict[str, object] = {
        "physicalLocation": {
            "artifactLocation": {"uri": _uri(Path(each.place.file))},
            "region": {"startLine": max(1, each.place.line)},
        }
    }
    if each.site.rung is not None:
        name = f"{each.site.routine}, {each.site.place}"
        location["logicalLocations"] = [{"fullyQualifiedName": name, "kind": "function"}]
    return location


def _uri(path: Path) -> str:
    """Return a file as a URI reference: relative to the folder, or absolute [section 3.4.3]."""
    return path.as_uri() if path.is_absolute() else quote(path.as_posix())


def as_junit(report: CheckReport, name: str) -> str:
    """Return the report as JUnit XML: one test case per rule, which fails if the rule has findings.

    Args:
        name: name of the test suite, such as the rack file.
    """
    cases = []
    failed = {finding.rule for finding in report.findings}
    for rule in RULES:
        own = [finding for finding in report.findings if finding.rule == rule.id]
        failures = "".join(_failure(finding) for finding in own)
        cases.append(f'  <testcase classname={quoteattr(name)} name="{rule.id}">{failures}</testcase>')
    head = f'<testsuite name={quoteattr(name)} tests="{len(RULES)}" failures="{len(failed)}" errors="0">'
    return "\n".join(['<?xml version="1.0" encoding="utf-8"?>', head, *cases, "</testsuite>"])


def _failure(each: Finding) -> str:
    text = quoteattr(f"{each.place.file}:{each.place.line}: {each.text}")
    return f"\n    <failure type={quoteattr(each.row.level)} message={text}>{escape(str(each))}</failure>\n  "
