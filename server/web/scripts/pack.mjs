// SPDX-License-Identifier: GPL-3.0-or-later
// Writes files, as they are and gzipped, one behind the other into assets.bin, and assets.cpp with where each is.
import {createHash} from 'node:crypto';
import {writeFileSync} from 'node:fs';
import path from 'node:path';
import {gzipSync} from 'node:zlib';

const types = {
  '.html': 'text/html; charset=utf-8',
  '.js': 'text/javascript; charset=utf-8',
  '.css': 'text/css; charset=utf-8',
  '.svg': 'image/svg+xml',
  '.wasm': 'application/wasm',
  '.json': 'application/json',
  '.ply': 'application/octet-stream',
};

export function packAssets(files, output) {
  const parts = [];
  let size = 0;
  const append = (bytes) => {
    const place = {offset: size, length: bytes.length};
    parts.push(bytes);
    size += bytes.length;
    return place;
  };
  const rows = [...files].sort((a, b) => (a.path < b.path ? -1 : 1)).map((file) => {
    const type = types[path.extname(file.path)];
    if (!type) throw new Error(`${file.path}: its media type is not known here`);
    const identity = append(file.bytes);
    const packed = gzipSync(file.bytes, {level: 9});
    const worth = packed.length < 0.95 * file.bytes.length;
    const gzip = worth ? append(packed) : {offset: 0, length: 0};
    const tag = createHash('sha256').update(file.bytes).digest('hex').slice(0, 24);
    return `    {"${file.path}", "${type}", "\\"${tag}\\"", "\\"${tag}-gzip\\"", piece(${identity.offset}, ${
               identity.length}), ` +
        `piece(${gzip.offset}, ${gzip.length}), ${file.immutable}},`;
  });
  writeFileSync(path.join(output, 'assets.bin'), Buffer.concat(parts));
  writeFileSync(
      path.join(output, 'assets.cpp'),
      `#include <array>
#include <cstddef>

#include "web/assets.hpp"

asm(".section .rodata\\n.balign 16\\nsurfaced_viewer_assets:\\n.incbin \\"${
          path.join(output, 'assets.bin')}\\"\\n.previous\\n");
extern "C" const char surfaced_viewer_assets[];

namespace surfaced::web {
namespace {

std::string_view piece(std::size_t offset, std::size_t length) { return {surfaced_viewer_assets + offset, length}; }

const std::array<Asset, ${rows.length}> kAssets{{
${rows.join('\n')}
}};

}  // namespace

std::span<const Asset> assets() { return kAssets; }

}  // namespace surfaced::web
`);
}
