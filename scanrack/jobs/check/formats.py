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


def _finding(finding: Finding) -> dict[str, object]:
    """Return a finding for --json, with its place in the file and, within a routine, its place there."""
    row: dict[str, object] = {
        "rule": finding.rule,
        "level": finding.row.level,
        "file": finding.place.file,
        "line": finding.place.line,
        "text": finding.text,
        "remedy": finding.row.remedy,
    }
    if finding.site.rung is not None:
        # "line" is already the line of the file
        number = "routine_line" if finding.site.unit == "line" else finding.site.unit
        row |= {"routine": finding.site.routine, number: finding.site.rung}
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


def _location(finding: Finding) -> dict[str, object]:
    """Return a finding's place for SARIF, with the routine and rung or line, if it has one."""
    location: dict[str, object] = {
        "physicalLocation": {
            "artifactLocation": {"uri": _uri(Path(finding.place.file))},
            "region": {"startLine": max(1, finding.place.line)},
        }
    }
    if finding.site.rung is not None:
        name = f"{finding.site.routine}, {finding.site.place}"
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
        rule_findings = [finding for finding in report.findings if finding.rule == rule.id]
        failures = "".join(_failure(finding) for finding in rule_findings)
        cases.append(f'  <testcase classname={quoteattr(name)} name="{rule.id}">{failures}</testcase>')
    head = f'<testsuite name={quoteattr(name)} tests="{len(RULES)}" failures="{len(failed)}" errors="0">'
    return "\n".join(['<?xml version="1.0" encoding="utf-8"?>', head, *cases, "</testsuite>"])


def _failure(finding: Finding) -> str:
    level = quoteattr(finding.row.level)
    text = quoteattr(f"{finding.place.file}:{finding.place.line}: {finding.text}")
    return f"\n    <failure type={level} message={text}>{escape(str(finding))}</failure>\n  "
