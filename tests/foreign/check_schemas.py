#!/usr/bin/env python3
"""Checks JSON Schemas and the reports that they describe.

Usage: check_schemas.py DIRECTORY

DIRECTORY contains pairs I.schema.json and I.json. I.json is one report, or one report on each line. Every schema must be valid, and every
report must match its schema. A report with one more field in any of its objects must not match. Prints a line for each pair.

Python packages: jsonschema (from PyPI). Tried with jsonschema 4.26.0.
"""

import json
import pathlib
import sys

from jsonschema import Draft202012Validator

# Of equal objects in a list, such as rounds, only the first few get another field.
MOST = 3


def reports(path):
    """The reports of a file."""
    text = path.read_text()
    try:
        return [json.loads(text)]
    except json.JSONDecodeError:
        return [json.loads(line) for line in text.splitlines()]


def objects(value):
    """All objects within a value."""
    if isinstance(value, dict):
        yield value
    inner = value.values() if isinstance(value, dict) else value[:MOST] if isinstance(value, list) else []
    for one in inner:
        yield from objects(one)


def main(directory):
    for path in sorted(directory.glob("*.schema.json")):
        schema = json.loads(path.read_text())
        Draft202012Validator.check_schema(schema)
        validator = Draft202012Validator(schema)
        found = reports(path.with_name(path.name.replace(".schema", "")))
        planted = 0
        for report in found:
            validator.validate(report)
        for report in found[:MOST]:
            for one in objects(report):
                one["planted"] = "another field"
                assert not validator.is_valid(report), f"{path.name}: {one}"
                del one["planted"]
                planted += 1
        print(f"{schema['title']}: {len(found)} reports, {planted} planted fields")


main(pathlib.Path(sys.argv[1]))
