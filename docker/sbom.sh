#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# A bill of materials (SPDX 2.3, JSON) and the licence texts, both from what dpkg knows.
#   sbom.sh packages PACKAGE... > ROWS            rows of the given packages, as JSON without the brackets
#   sbom.sh document VERSION ROWS-FILE > SPDX     all packages of this system, and those rows: compiled into the binary
#   sbom.sh licences [PACKAGE...] > TEXT          their copyright files, of all installed packages without a name
set -eu

rows() { # rows KIND [PACKAGE...]: KIND tells what is installed from what is compiled in
  kind=$1
  shift
  dpkg-query -W -f "\${db:Status-Status} {\"SPDXID\": \"SPDXRef-$kind-\${Package}\", \"name\": \"\${Package}\", \"versionInfo\": \"\${Version}\", \"supplier\": \"Organization: Debian\", \"downloadLocation\": \"https://snapshot.debian.org/package/\${source:Package}/\${source:Version}/\", \"filesAnalyzed\": false, \"licenseConcluded\": \"NOASSERTION\", \"licenseDeclared\": \"NOASSERTION\", \"copyrightText\": \"NOASSERTION\", \"externalRefs\": [{\"referenceCategory\": \"PACKAGE-MANAGER\", \"referenceType\": \"purl\", \"referenceLocator\": \"pkg:deb/debian/\${Package}@\${Version}?arch=\${Architecture}\"}]}\n" "$@" |
    sed -n 's/^installed //p' | sed -e '$!s/$/,/' -e ':id' -e 's/\("SPDXID": "[^"]*\)+/\1-plus/; t id' \
      -e ':purl' -e 's/\(pkg:deb[^"]*\)+/\1%2B/; t purl'  # an id has no plus, a purl an escaped one
}

related() { # relationships of rows on standard input
  sed -n 's/.*"SPDXID": "\([^"]*\)".*/\1/p' | while read -r id; do
    case $id in
      SPDXRef-linked-*) kind=STATIC_LINK ;;
      *) kind=DEPENDS_ON ;;
    esac
    printf ',\n{"spdxElementId": "SPDXRef-surfaced", "relationshipType": "%s", "relatedSpdxElement": "%s"}' "$kind" "$id"
  done
}

document() {
  version=$1 linked=$2
  all=$(rows installed; echo ,; cat "$linked")
  created=$(date -u -d "@${SOURCE_DATE_EPOCH:-$(date +%s)}" +%Y-%m-%dT%H:%M:%SZ)
  cat <<END
{"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": "surfaced-$version",
"documentNamespace": "https://spdx.org/spdxdocs/surfaced-$version-$(printf %s "$all" | sha256sum | cut -c 1-32)",
"creationInfo": {"created": "$created", "creators": ["Tool: docker/sbom.sh"]},
"packages": [
{"SPDXID": "SPDXRef-surfaced", "name": "surfaced", "versionInfo": "$version", "downloadLocation": "NOASSERTION", "filesAnalyzed": false, "licenseConcluded": "GPL-3.0-or-later", "licenseDeclared": "GPL-3.0-or-later", "copyrightText": "NOASSERTION"},
$all
],
"relationships": [
{"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES", "relatedSpdxElement": "SPDXRef-surfaced"}$(printf '%s\n' "$all" | related)
]}
END
}

licences() {
  [ $# -gt 0 ] || set -- $(dpkg-query -W -f '${db:Status-Status} ${Package}\n' | sed -n 's/^installed //p')
  for package in "$@"; do
    file=/usr/share/doc/$package/copyright
    [ -f "$file" ] || continue
    printf '==== %s ====\n\n' "$package"
    cat "$file"
    echo
  done
}

command=$1
shift
case $command in
  packages) rows linked "$@" ;;
  document) document "$@" ;;
  licences) licences "$@" ;;
  *) echo "sbom.sh: packages, document or licences, not '$command'" >&2; exit 2 ;;
esac
