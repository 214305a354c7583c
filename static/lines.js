// Lines in one piece. The viewer draws each segment as an instance of its own, which without a graphics card costs ten
// times as much as the same triangles drawn together: so they are put together, with the attributes that its shader reads.

const whole = new WeakMap(); // by the viewer's geometry

const instanced = ({ data, isInstancedBufferAttribute }) => isInstancedBufferAttribute || data?.isInstancedInterleavedBuffer;

/** Values of an attribute for all corners of all instances, one instance after the other. */
function spread(attribute, instances, corners) {
  const { itemSize, data, offset = 0 } = attribute;
  const [from, stride] = data ? [data.array, data.stride] : [attribute.array, itemSize];
  const values = new Float32Array(instances * corners * itemSize);
  const own = instanced(attribute);
  for (let instance = 0, at = 0; instance < instances; instance++)
    for (let corner = 0; corner < corners; corner++) {
      const first = offset + stride * (own ? instance : corner);
      for (let part = 0; part < itemSize; part++) values[at++] = from[first + part];
    }
  return values;
}

function indices({ array }, instances, corners) {
  const all = new Array(instances * array.length);
  for (let instance = 0, at = 0; instance < instances; instance++)
    for (const corner of array) all[at++] = instance * corners + corner;
  return all;
}

// The class of geometries that have no instances: no other way leads to it from outside of the viewer.
function plain(geometry) {
  let made = geometry.constructor;
  while (Object.getPrototypeOf(made).prototype?.setIndex) made = Object.getPrototypeOf(made);
  return new made();
}

function inOnePiece(geometry) {
  const { position, instanceStart } = geometry.attributes;
  const [instances, corners, made] = [instanceStart.count, position.count, plain(geometry)];
  for (const [name, attribute] of Object.entries(geometry.attributes))
    made.setAttribute(name, new position.constructor(spread(attribute, instances, corners), attribute.itemSize));
  made.setIndex(indices(geometry.index, instances, corners));
  made.boundingSphere = geometry.boundingSphere;
  made.boundingBox = geometry.boundingBox;
  geometry.addEventListener("dispose", () => made.dispose());
  return made;
}

/** Before a scene is drawn: put together the lines in it that are new. */
export function together(scene) {
  scene.traverseVisible((thing) => {
    const { geometry } = thing;
    if (!geometry?.isLineSegmentsGeometry) return;
    if (!whole.has(geometry)) whole.set(geometry, inOnePiece(geometry));
    thing.geometry = whole.get(geometry);
  });
}
