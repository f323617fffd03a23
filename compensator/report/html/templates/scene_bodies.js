// Bodies of a scene as three.js takes them; a body may have other faces from stage to stage.
const SceneBodies = (() => {
  const {unpacked} = SceneNumbers;

  function geometry(body) {
    const made = new THREE.BufferGeometry();
    const places = body.places && unpacked(body.places, "s");
    const vertices = places ? Float32Array.from(places, (v, i) => body.low[i % 3] + v * body.unit[i % 3]) : unpacked(body.vertices);
    made.setAttribute("position", new THREE.BufferAttribute(vertices, 3));
    made.setIndex(new THREE.BufferAttribute(unpacked(body.faces, body.wide ? "u" : "s"), 1));
    if (body.smooth) made.computeVertexNormals();
    return made;
  }

  // the faces of every stage as an index of its own; runs: how many faces, first stage that has them, first that has not
  function staged(body, all) {
    const runs = body.stages.runs, stage = unpacked(body.stages.stage, "b"), index = [];
    for (let s = Math.max(...stage); s >= 0; s--) {
      const parts = [];
      for (let r = 0, face = 0; r < runs.length; face += runs[r], r += 3)
        if (runs[r + 1] <= s && s < runs[r + 2]) parts.push(all.subarray(3 * face, 3 * (face + runs[r])));
      const joined = new all.constructor(parts.reduce((sum, part) => sum + part.length, 0));
      parts.reduce((at, part) => { joined.set(part, at); return at + part.length; }, 0);
      index[s] = new THREE.BufferAttribute(joined, 1);
    }
    return {stage, index};
  }

  function material(body) {
    const clear = body.opacity < 1;
    return new THREE.MeshStandardMaterial({
      color: body.colour, roughness: 0.75, metalness: 0.1, flatShading: !body.smooth, transparent: clear,
      opacity: body.opacity, depthWrite: !clear, side: THREE.DoubleSide,
    });
  }
  return {geometry, staged, material};
})();
