// What the Draco wrapper would take from Node.
export default {};
