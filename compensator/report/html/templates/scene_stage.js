// The stage: bodies, path and arrows in three dimensions. Placements come from the scene; none are computed here but
// the sum nominal + factor x deflection, entry by entry.
const SceneStage = (() => {
  const {unpacked, mapped, jointColour, GREY, range, between} = SceneNumbers;
  const {geometry, staged, material} = SceneBodies;
  const ARROWS = {force: "#d55e00", deflection: "#cc2f6b", correction: "#0072b2"};
  const RESIDUALS = {before: "#d55e00", after: "#0072b2"};
  const UP = new THREE.Vector3(0, 1, 0);

  class Arm {
    constructor(scene, parent) {
      this.group = new THREE.Group();
      parent.add(this.group);
      this.frames = Array.from({length: scene.links}, () => {
        const frame = new THREE.Group();
        frame.matrixAutoUpdate = false;
        this.group.add(frame);
        return frame;
      });
      this.arrows = Object.fromEntries(Object.entries(ARROWS).map(([name, colour]) => [name, arrow(colour)]));
      Object.values(this.arrows).forEach(a => this.group.add(a));
    }
  }

  function arrow(colour) {
    const group = new THREE.Group(), material = new THREE.MeshBasicMaterial({color: colour, depthTest: false, transparent: true});
    const shaft = new THREE.Mesh(new THREE.CylinderGeometry(0.005, 0.005, 1, 12), material);
    const head = new THREE.Mesh(new THREE.ConeGeometry(0.015, 0.045, 16), material);
    shaft.renderOrder = head.renderOrder = 5;
    group.add(shaft, head);
    return group;
  }

  function pointed(group, from, along, size) {
    const length = along.length();
    group.visible = length > 1e-6;
    if (!group.visible) return;
    const [shaft, head] = group.children, cone = Math.min(0.045 * size, length);
    group.position.copy(from);
    group.quaternion.setFromUnitVectors(UP, along.clone().normalize());
    shaft.scale.set(size, Math.max(length - cone, 1e-6), size);
    shaft.position.y = (length - cone) / 2;
    head.scale.set(size, cone / 0.045, size);
    head.position.y = length - cone / 2;
  }

  class Stage {
    constructor(canvas) {
      this.canvas = canvas;
      this.renderer = new THREE.WebGLRenderer({canvas, antialias: true, preserveDrawingBuffer: true});
      this.renderer.setScissorTest(true);
      this.camera = new THREE.PerspectiveCamera(35, 1, 0.02, 80);
      this.camera.up.set(0, 0, 1);
      this.controls = new THREE.OrbitControls(this.camera, canvas);
      this.controls.addEventListener("change", () => this.draw());
    }

    load(scene) {
      this.data = scene;
      this.root = new THREE.Scene();
      this.root.background = new THREE.Color("#eef1f4");
      this.root.add(new THREE.HemisphereLight("#ffffff", "#8899aa", 2.2));
      const sun = new THREE.DirectionalLight("#ffffff", 1.6);
      sun.position.set(2, -3, 5);
      this.root.add(sun);
      const floor = new THREE.GridHelper(4 * Math.ceil(scene.reach), 8 * Math.ceil(scene.reach), "#c3cad1", "#d9dee3");
      floor.rotation.x = Math.PI / 2;
      this.floor = new THREE.Group();
      this.floor.add(floor);
      this.root.add(this.floor);
      this.work = new THREE.Group();
      this.work.matrixAutoUpdate = false;
      this.root.add(this.work);
      const s = scene.stations;
      this.arrays = {};
      for (const name of ["nominal", "before", "after", "force", "deflection", "correction", "work", "floor"])
        if (s[name]) this.arrays[name] = unpacked(s[name]);
      this.arms = {before: new Arm(scene, this.root)};
      if (s.after) this.arms.after = new Arm(scene, this.root);
      this.bodies = [];
      for (const body of scene.bodies) this._add(body);
      this.residuals = scene.residuals ? this._residuals(scene.residuals) : null;
      if (scene.path) this._path(scene.path);
      const longest = (values, width) => {
        let most = 0;
        for (let k = 0; k + 2 < values.length; k += width) most = Math.max(most, Math.hypot(values[k], values[k + 1], values[k + 2]));
        return most;
      };
      this.most = this.arrays.force ? longest(this.arrays.force, 3) || 1 : 1;
    }

    // a pool of arrows for each side, as many as the set-up with the most readings has
    _residuals(given) {
      const most = Math.max(...given.first.slice(1).map((end, k) => end - given.first[k]));
      const out = {first: given.first, at: unpacked(given.at), sides: {}};
      for (const [side, arm] of Object.entries(this.arms)) {
        const arrows = Array.from({length: most}, () => arrow(RESIDUALS[side]));
        arm.group.add(...arrows);
        out.sides[side] = {arrows, size: unpacked(given[side])};
      }
      return out;
    }

    _readings(side, at, factor, shown, size) {
      const {first, at: places, sides} = this.residuals, k = Math.round(at), start = first[k];
      sides[side].arrows.forEach((a, i) => {
        const row = 3 * (start + i), there = start + i < first[k + 1] && shown.residuals !== false;
        const part = values => new THREE.Vector3(...values.subarray(row, row + 3));
        pointed(a, there ? part(places) : new THREE.Vector3(), there ? part(sides[side].size).multiplyScalar(factor) : new THREE.Vector3(), size);
      });
    }

    _add(body) {
      const shape = geometry(body), look = material(body);
      const parents = body.frame === -1 ? [this.work] : body.frame === -2 ? [this.floor] : Object.values(this.arms).map(arm => arm.frames[body.frame]);
      for (const parent of parents) {
        const mesh = new THREE.Mesh(shape, look);
        mesh.renderOrder = body.opacity < 1 ? 2 : 0;
        parent.add(mesh);
        this.bodies.push({mesh, kind: body.kind, tool: body.tool, stages: body.stages && staged(body, shape.index.array)});
      }
    }

    _path(path) {
      const place = unpacked(path.position), error = unpacked(path.error);
      this.path = {place, error, cut: unpacked(path.cut, "b"), count: path.count};
      this.line = this._line(3.5);
      this.ghost = this._line(1.6);
      this.line.geometry.setPositions(this._ends(place));
      this.ghost.geometry.setPositions(this._ends(place));
      this.ghost.material.color.set("#cc2f6b");
      this.ghost.material.vertexColors = false;
    }

    _line(width) {
      const look = new THREE.LineMaterial({linewidth: width, vertexColors: true});
      const line = new THREE.LineSegments2(new THREE.LineSegmentsGeometry(), look);
      line.frustumCulled = false;
      line.renderOrder = 1;
      this.work.add(line);
      return line;
    }

    // both ends of every segment
    _ends(points) {
      const out = new Float32Array(6 * Math.max(this.path.count - 1, 0));
      for (let k = 0; k + 1 < this.path.count; k++) out.set(points.subarray(3 * k, 3 * k + 6), 6 * k);
      return out;
    }

    colour(choice) {
      const values = unpacked(choice.value), {cut, count} = this.path, [low, high] = range(values, cut);
      const out = new Float32Array(6 * Math.max(count - 1, 0));
      for (let k = 1; k < count; k++) {
        const v = values[k];
        const c = !cut[k] || !Number.isFinite(v) ? GREY : choice.joints ? jointColour(v) : mapped((v - low) / (high - low));
        out.set([...c, ...c], 6 * (k - 1));
      }
      this.line.geometry.setColors(out);
      return [low, high];
    }

    // where the path would be with its deflection enlarged
    enlarged(factor) {
      if (!this.path || factor === this.ghosted) return;
      this.ghosted = factor;
      const {place, error} = this.path, moved = place.map((v, i) => v + factor * error[i]);
      this.ghost.geometry.setPositions(this._ends(moved));
    }

    link(side, k, at, factor) {
      const width = 12 * this.data.links, out = [];
      for (let i = 0; i < 12; i++)
        out.push(between(this.arrays.nominal, width, at, 12 * k + i) + factor * between(this.arrays[side], width, at, 12 * k + i));
      return out;
    }

    pose(at, factor, shown) {
      for (const [side, arm] of Object.entries(this.arms)) {
        arm.frames.forEach((frame, k) => { frame.matrix.set(...this.link(side, k, at, factor), 0, 0, 0, 1); });
      }
      const still = !this.data.stations.moves, m = [];
      for (let i = 0; i < 12; i++) m.push(between(this.arrays.work, 12, still ? 0 : at, i));
      this.work.matrix.set(...m, 0, 0, 0, 1);
      if (this.arrays.floor) this.floor.position.set(...[0, 1, 2].map(i => between(this.arrays.floor, 3, at, i)));
      this.now = [at, factor, shown];
      const tool = this.data.stations.tool[Math.round(at)];
      for (const b of this.bodies) {
        b.mesh.visible = shown[b.kind] !== false && (b.tool === null || b.tool === tool);
        if (b.stages) b.mesh.geometry.setIndex(b.stages.index[b.stages.stage[Math.floor(at)]]);
      }
      if (this.line) {
        this.line.visible = shown.path !== false;
        this.ghostly = shown.ghost !== false && shown.path !== false;
      }
      this.enlarged(factor);
    }

    _arrows(side, arm, at, factor, shown) {
      const tip = this.data.links - 1, far = this.camera.position.distanceTo(this.controls.target), size = 0.15 * far;
      const vector = (name, scale) => this.arrays[name]
        ? new THREE.Vector3(...[0, 1, 2].map(i => scale * between(this.arrays[name], 3, at, i))) : new THREE.Vector3();
      const m = this.link(side, tip, at, factor), n = this.link(side, tip, at, 0);
      const here = new THREE.Vector3(m[3], m[7], m[11]), nominal = new THREE.Vector3(n[3], n[7], n[11]);
      const on = name => shown[name] !== false;
      pointed(arm.arrows.force, here, on("force") ? vector("force", 0.13 * far / this.most) : new THREE.Vector3(), size);
      const off = side === "before" && on("deflection") ? vector("deflection", factor) : new THREE.Vector3();
      pointed(arm.arrows.deflection, nominal, off, size);
      const moved = side === "after" && on("correction") ? vector("correction", factor) : new THREE.Vector3();
      pointed(arm.arrows.correction, nominal, moved, size);
      if (this.residuals) this._readings(side, at, factor, shown, size);
    }

    look(whole, at) {
      const box = whole ? this._armBox(at) : this._pathBox(at);
      const [x, y] = box.around, angle = Math.atan2(y, x) - (whole ? 1.15 : 0.9), up = 0.42;
      const far = box.size / (2 * Math.tan(this.camera.fov * Math.PI / 360)) / Math.min(1, this.camera.aspect) + 0.02;
      this.controls.target.set(...box.middle);
      this.camera.position.set(
        box.middle[0] + far * Math.cos(up) * Math.cos(angle), box.middle[1] + far * Math.cos(up) * Math.sin(angle),
        box.middle[2] + far * Math.sin(up));
      this.controls.update();
      this.draw();
    }

    _boxOf(points, spare) {
      const low = [0, 1, 2].map(i => Math.min(...points.map(p => p[i]))), high = [0, 1, 2].map(i => Math.max(...points.map(p => p[i])));
      const middle = low.map((v, i) => (v + high[i]) / 2);
      return {middle, around: middle, size: Math.hypot(...high.map((v, i) => v - low[i])) + spare};
    }

    _armBox(at) {
      const points = [];
      for (let k = 0; k < this.data.links; k++) {
        const m = this.link("before", k, at, 0);
        points.push([m[3], m[7], m[11]]);
      }
      return this._boxOf(points, 0.35 * this.data.reach);
    }

    _pathBox(at) {
      const e = this.work.matrix.elements, points = [], tip = this.link("before", this.data.links - 1, at, 0);
      const all = this.path ? this.path.place : [];
      for (let k = 0; k < all.length; k += 3 * Math.max(1, Math.floor(all.length / 900))) {
        const [x, y, z] = all.subarray(k, k + 3);
        points.push([0, 1, 2].map(i => e[i] * x + e[4 + i] * y + e[8 + i] * z + e[12 + i]));
      }
      const box = this._boxOf(points.length ? points : [[tip[3], tip[7], tip[11]]], 0.12);
      return {...box, size: Math.min(box.size * 1.1, 2 * this.data.reach)};
    }

    resize(sides) {
      const {clientWidth: width, clientHeight: height} = this.canvas;
      this.sides = sides;
      this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / sides.length / Math.max(height, 1);
      this.camera.updateProjectionMatrix();
    }

    draw() {
      if (!this.root || !this.sides) return;
      const {clientWidth: width, clientHeight: height} = this.canvas, wide = width / this.sides.length;
      this.sides.forEach((side, i) => {
        for (const [name, arm] of Object.entries(this.arms)) arm.group.visible = name === side;
        if (this.now) this._arrows(side, this.arms[side], ...this.now);
        if (this.ghost) this.ghost.visible = side === "before" && this.ghostly;
        this.renderer.setViewport(i * wide, 0, wide, height);
        this.renderer.setScissor(i * wide, 0, wide, height);
        this.renderer.render(this.root, this.camera);
      });
    }
  }
  return Stage;
})();
