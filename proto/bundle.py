#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the contract as one JSON file: openapi.yaml with the schemas of schema/ among its components.

usage: bundle.py OUTPUT [OUTPUT_3_0 [CONTACT]]

OUTPUT_3_0 is the same in OpenAPI 3.0, which knows less of JSON Schema: types that may be null become nullable,
constants enumerations; keywords that it has not are left out. CONTACT, an address or a URL, goes into both.
"""
import json
import sys
from pathlib import Path

import yaml

HERE = Path(__file__).parent


def rewrite(node, schema=None):
    """Points references to schema files, and those within a schema file, at the bundle's components."""
    if isinstance(node, list):
        return [rewrite(item, schema) for item in node]
    if not isinstance(node, dict):
        return node
    result = {key: rewrite(value, schema) for key, value in node.items() if key != "$schema" or schema is None}
    reference = result.get("$ref")
    if isinstance(reference, str):
        file, _, place = reference.partition("#")
        if file.endswith(".json"):
            result["$ref"] = "#/components/schemas/" + Path(file).stem + place
        elif schema is not None and reference.startswith("#/"):
            result["$ref"] = f"#/components/schemas/{schema}/{reference[2:]}"
    return result


def downgrade(node):
    """A node of the bundle in the words of OpenAPI 3.0."""
    if isinstance(node, list):
        return [downgrade(item) for item in node]
    if not isinstance(node, dict):
        return node
    dropped = {"$schema", "$comment", "contentMediaType", "contentEncoding", "patternProperties", "x-unit"}
    result = {key: downgrade(value) for key, value in node.items() if key not in dropped}
    if "contentMediaType" in node and node.get("type") == "string":
        result["format"] = "binary"
    if "const" in node:
        result["enum"] = [result.pop("const")]
    if isinstance(node.get("type"), list):
        kinds = [kind for kind in node["type"] if kind != "null"]
        del result["type"]
        if len(kinds) == 1:
            result["type"] = kinds[0]
        else:
            result["anyOf"] = [{"type": kind} for kind in kinds]
        if "null" in node["type"]:
            result["nullable"] = True
    for union in ("oneOf", "anyOf"):
        kinds = node.get(union)
        if isinstance(kinds, list) and {"type": "null"} in kinds:
            result[union] = [downgrade(kind) for kind in kinds if kind != {"type": "null"}]
            result["nullable"] = True
    for bound in ("Minimum", "Maximum"):
        value = result.get("exclusive" + bound)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            result[bound.lower()], result["exclusive" + bound] = value, True
    if isinstance(result.get("enum"), list) and None in result["enum"]:
        result["nullable"] = True
    return result


def write(path, contract):
    Path(path).write_text(json.dumps(contract, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def main():
    contract = rewrite(yaml.safe_load((HERE / "openapi.yaml").read_text(encoding="utf-8")))
    schemas = contract.setdefault("components", {}).setdefault("schemas", {})
    for path in sorted((HERE / "schema").glob("*.json")):
        schemas[path.stem] = rewrite(json.loads(path.read_text(encoding="utf-8")), path.stem)
    contact = sys.argv[3] if len(sys.argv) > 3 else ""
    if contact:
        contract["info"]["contact"] = {"url" if "://" in contact else "email": contact}
    write(sys.argv[1], contract)
    if len(sys.argv) > 2:
        older = downgrade(contract)
        older["openapi"] = "3.0.3"
        older["info"].pop("summary", None)
        older["info"]["license"].pop("identifier", None)
        write(sys.argv[2], older)


if __name__ == "__main__":
    main()
