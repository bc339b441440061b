// SPDX-License-Identifier: GPL-3.0-or-later
/** A mesh as the viewer works with it. */
export interface MeshData {
  /** xyz of each vertex, less the origin. */
  positions: Float32Array;
  /** Three vertices a triangle. */
  index: Uint32Array;
  origin: [number, number, number];
}

export const triangleCount = (mesh: MeshData): number => mesh.index.length / 3;
