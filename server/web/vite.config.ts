// SPDX-License-Identifier: GPL-3.0-or-later
import {defineConfig} from 'vite';

export default defineConfig({
  base: './',
  // The Draco wrapper asks for Node's modules where it runs under Node; here it does not.
  resolve: {alias: {fs: '/src/empty.ts', path: '/src/empty.ts'}},
  build: {
    target: 'es2022',
    assetsInlineLimit: 0,
    modulePreload: {polyfill: false},
    chunkSizeWarningLimit: 1500,
    sourcemap: false,
  },
  worker: {format: 'es'},
});
