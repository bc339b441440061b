// SPDX-License-Identifier: GPL-3.0-or-later
// The command that repeats what the page has just done.
const quoted = (text: string): string => `'${text.replaceAll('\'', '\'\\\'\'')}'`;

export function curlLine(
    base: string, file: string, method: string, parameters: Record<string, unknown>, key: boolean): string {
  const query = new URLSearchParams({
    method,
    ...Object.fromEntries(Object.entries(parameters).map(([name, value]) => [name, String(value)])),
    output: 'glb'
  });
  const header = key ? '-H "Authorization: Bearer $SURFACED_KEY" ' : '';
  const mesh = `${file.replace(/\.[^.]*$/, '') || 'mesh'}.glb`;
  return `curl --fail -sS ${header}--data-binary ${quoted(`@${file}`)} -o ${quoted(mesh)} ${
      quoted(`${base}v1/reconstruct?${query.toString()}`)}`;
}
