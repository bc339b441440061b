#!/usr/bin/env python3
"""Writes the contract as one JSON file: openapi.yaml with the schemas of schema/ among its components.

usage: bundle.py OUTPUT
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
        if reference.endswith(".json"):
            result["$ref"] = "#/components/schemas/" + Path(reference).stem
        elif schema is not None and reference.startswith("#/"):
            result["$ref"] = f"#/components/schemas/{schema}/{reference[2:]}"
    return result


def main():
    contract = rewrite(yaml.safe_load((HERE / "openapi.yaml").read_text(encoding="utf-8")))
    schemas = contract.setdefault("components", {}).setdefault("schemas", {})
    for path in sorted((HERE / "schema").glob("*.json")):
        schemas[path.stem] = rewrite(json.loads(path.read_text(encoding="utf-8")), path.stem)
    text = json.dumps(contract, indent=1, ensure_ascii=False)
    Path(sys.argv[1]).write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
