// SPDX-License-Identifier: GPL-3.0-or-later
declare const __VERSION__: string;
declare const __SOURCE_URL__: string;

declare module 'three/examples/jsm/libs/draco/draco_wasm_wrapper.js' {
  const createDecoder: (options: {wasmBinary: ArrayBuffer}) => Promise<unknown>;
  export default createDecoder;
}
