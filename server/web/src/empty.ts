// SPDX-License-Identifier: GPL-3.0-or-later
// What the Draco wrapper would take from Node.
export default {};
