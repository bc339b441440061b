// SPDX-License-Identifier: GPL-3.0-or-later
// All tests of the page but those of its speed, in one process.
import {readdirSync} from 'node:fs';

const files =
    readdirSync(import.meta.dirname ?? new URL('.', import.meta.url)).filter((name) => name.endsWith('.test.mjs'));
for (const name of files.filter((each) => each !== 'speed.test.mjs').sort()) await import(`./${name}`);
