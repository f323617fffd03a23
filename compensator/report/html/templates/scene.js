// The scene with its controls. Text of files goes in as text only.
const SceneView = (() => {
  const {unpacked, jointColour, JOINTS, STOPS, said, between} = SceneNumbers;
  const LAYERS = {
    arm: "arm", tool: "tool", cutter: "cutter", stock: "stock", left: "what is left of it", part: "part", fixture: "fixtures",
    path: "path", ghost: "path, deflected", force: "force", deflection: "deflection", correction: "correction",
    reflector: "reflectors", residuals: "residuals",
  };
  const UNKNOWN = 127, WITHOUT = -128, SECONDS = 20, MOST = 2000;

  function element(tag, text = "", attributes = {}) {
    const made = document.createElement(tag);
    made.textContent = text;
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    return made;
  }

  class View {
    constructor(root, data, words) {
      this.root = root;
      this.words = words;
      this.find = name => root.querySelector(`[data-do=${name}]`);
      this.show = name => root.querySelector(`[data-show=${name}]`);
      this.shown = {};
      this.sides = ["before"];
      try {
        this.stage = new SceneStage(root.querySelector("canvas"));
      } catch (error) {
        root.querySelector(".missing").hidden = false;
      }
      this._controls();
      this.load(data);
      if (this.stage) new ResizeObserver(() => this._resized()).observe(root.querySelector(".stage"));
    }

    // another scene in the place of this one; keeps camera, factor and colour
    load(data) {
      const first = !this.data;
      this.data = data;
      const s = data.stations, j = data.joints;
      this.arrays = {};
      for (const name of ["force", "deflection", "correction", "remaining"]) if (s[name]) this.arrays[name] = unpacked(s[name]);
      this.q = {before: unpacked(j.q), after: j.commanded ? unpacked(j.commanded) : null};
      this.lamps = {before: unpacked(j.lamps, "i"), after: j.lamps_after ? unpacked(j.lamps_after, "i") : null};
      this.at = first ? data.worst : Math.min(this.at, s.count - 1);
      if (first) this.factor = data.factor;
      if (!s.after) this.sides = ["before"];
      const walk = this.find("walk");
      walk.max = s.count - 1;
      if (this.stage) this.stage.load(data);
      this._choices();
      this._joints();
      this._findings();
      if (this.stage) {
        this.stage.resize(this.sides);
        this._colour();
        this.stage.pose(this.at, this.factor, this.shown);
        if (first) this.stage.look(true, this.at);
      }
      this.go(this.at);
    }

    _controls() {
      this.find("walk").addEventListener("input", e => { this.pause(); this.go(Number(e.target.value)); });
      this.find("play").addEventListener("click", () => this.playing ? this.pause() : this.play());
      this.find("factor").addEventListener("input", e => this.enlarge(Math.round(Math.pow(MOST, e.target.value / 1000))));
      this.find("colour").addEventListener("change", () => { this._colour(); this._draw(); });
      this.find("arm").addEventListener("click", () => this.stage && this.stage.look(true, this.at));
      this.find("cut").addEventListener("click", () => this.stage && this.stage.look(false, this.at));
      this.root.querySelector("canvas").addEventListener("keydown", e => this._turned(e));
      document.addEventListener("keydown", e => this._key(e));
    }

    _key(event) {
      const tag = event.target.tagName;
      if (event.ctrlKey || event.metaKey || event.altKey || ["INPUT", "SELECT", "TEXTAREA", "CANVAS"].includes(tag)) return;
      const step = {ArrowLeft: -1, ArrowRight: 1, PageUp: -20, PageDown: 20}[event.key];
      if (event.key === " " && tag !== "BUTTON") this.playing ? this.pause() : this.play();
      else if (event.key === "ArrowLeft" || event.key === "ArrowRight") { this.pause(); this.go(Math.round(this.at) + step); }
      else return;
      event.preventDefault();
    }

    _turned(event) {
      const stage = this.stage, turns = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};
      if (!stage || event.ctrlKey || event.metaKey) return;
      const arm = stage.camera.position.clone().sub(stage.controls.target);
      if (turns[event.key]) {
        const [x, y, z] = arm.toArray(), flat = Math.hypot(x, y), far = arm.length();
        const angle = Math.atan2(y, x) + 0.1 * turns[event.key][0];
        const up = Math.min(Math.max(Math.atan2(z, flat) - 0.1 * turns[event.key][1], -1.5), 1.5);
        arm.set(far * Math.cos(up) * Math.cos(angle), far * Math.cos(up) * Math.sin(angle), far * Math.sin(up));
      } else if (event.key === "+" || event.key === "-") arm.multiplyScalar(event.key === "+" ? 0.85 : 1 / 0.85);
      else return;
      event.preventDefault();
      stage.camera.position.copy(stage.controls.target).add(arm);
      stage.controls.update();
      stage.draw();
    }

    play() {
      const count = this.data.stations.count;
      if (count < 2) return;
      if (this.at >= count - 1) this.at = 0;
      this.playing = true;
      this._playbutton();
      let last = performance.now();
      const tick = now => {
        if (!this.playing) return;
        const speed = Number(this.find("speed").value) * Math.max(count / SECONDS, 4);
        this.go(this.at + speed * Math.min((now - last) / 1000, 0.2));
        last = now;
        if (this.at >= count - 1) this.pause(); else requestAnimationFrame(tick);
      };
      requestAnimationFrame(tick);
    }

    pause() {
      this.playing = false;
      this._playbutton();
    }

    _playbutton() {
      const button = this.find("play");
      button.textContent = this.playing ? "❚❚" : "▶";
      button.setAttribute("aria-label", this.playing ? "Pause" : "Play");
    }

    go(at) {
      if (this.data.residuals && !this.playing) at = Math.round(at);
      this.at = Math.min(Math.max(at, 0), this.data.stations.count - 1);
      this.find("walk").value = Math.round(this.at);
      this._where();
      this._bars();
      this._draw();
    }

    enlarge(factor) {
      this.factor = Math.min(Math.max(factor, 1), MOST);
      this._factor();
      this._draw();
    }

    _factor() {
      this.show("factor").textContent = this.factor;
      this.find("factor").value = Math.round(1000 * Math.log(this.factor) / Math.log(MOST));
      this.find("factor").setAttribute("aria-valuetext", `${this.factor} times`);
    }

    _draw() {
      if (!this.stage) return;
      this.stage.pose(this.at, this.factor, this.shown);
      this.stage.draw();
    }

    _resized() {
      this.stage.resize(this.sides);
      this.stage.draw();
    }

    // what a test or a curious reader asks: placement of link k, row by row, as it is drawn
    placement(k, side = this.sides[0]) {
      return this.stage.link(side, k, this.at, this.factor);
    }

    _choices() {
      const both = Boolean(this.data.stations.after), views = this.show("views"), name = this.words;
      const sides = both ? [["before"], ["after"], ["before", "after"]] : [];
      views.replaceChildren(...sides.map((list, k) => {
        const label = element("label"), radio = element("input", "", {type: "radio", name: "view", value: k});
        radio.checked = list.join() === this.sides.join();
        radio.addEventListener("change", () => { this.sides = list; this._sided(); });
        label.append(radio, ` ${list.length > 1 ? "both" : name[list[0]]}`);
        return label;
      }));
      const colour = this.find("colour"), chosen = colour.value, offered = this.data.path ? this.data.path.colours : [];
      colour.replaceChildren(...offered.map(c => element("option", c.label, {value: c.key})));
      if (offered.some(c => c.key === chosen)) colour.value = chosen;
      colour.parentElement.hidden = !offered.length;
      const kinds = new Set(this.data.bodies.map(b => b.kind)), s = this.data.stations;
      const vectors = ["force", "deflection", "correction"];
      const there = k => kinds.has(k) || (["path", "ghost"].includes(k) ? this.data.path : vectors.includes(k) ? s[k] : this.data[k]);
      this.find("cut").hidden = !this.data.path;
      this.show("layers").replaceChildren(...Object.keys(LAYERS).filter(there).map(kind => {
        const label = element("label"), box = element("input", "", {type: "checkbox", value: kind});
        if (kind === "stock" && kinds.has("left") && !(kind in this.shown)) this.shown.stock = false;
        box.checked = this.shown[kind] !== false;
        box.addEventListener("change", () => { this.shown[kind] = box.checked; this._draw(); });
        label.append(box, ` ${LAYERS[kind]}`);
        return label;
      }));
      this._factor();
      this._titles();
    }

    _sided() {
      this._titles();
      if (this.stage) this.stage.resize(this.sides);
      this.go(this.at);
    }

    _titles() {
      const texts = this.data.stations.after ? this.sides.map(side => this.words[side]) : [];
      this.root.querySelector(".titles").replaceChildren(...texts.map(text => element("span", text)));
    }

    _colour() {
      if (!this.stage) return;
      const legend = this.root.querySelector(".legend"), choice = this.data.path && this.data.path.colours.find(c => c.key === this.find("colour").value);
      if (!choice) return legend.replaceChildren();
      const [low, high] = this.stage.colour(choice), ends = element("span", "", {class: "ends"}), bar = element("i");
      if (choice.joints) {
        const swatches = this.data.joints.limits.map((_, j) => {
          const swatch = element("span", "", {class: "swatch"});
          swatch.style.background = JOINTS[(j + 1) % JOINTS.length];
          return [swatch, `${j + 1}`];
        });
        return legend.replaceChildren(element("b", choice.label), element("br"), ...swatches.flat());
      }
      bar.style.background = `linear-gradient(90deg, ${STOPS.map(c => `rgb(${c})`).join()})`;
      ends.append(element("span", said(low)), element("span", said(high)));
      legend.replaceChildren(element("b", choice.label), bar, ends);
    }

    _joints() {
      const table = this.show("joints"), caption = table.caption;
      const rows = this.data.joints.limits.map((limits, j) => {
        const row = element("tr"), track = element("div", "", {class: "track", role: "meter", "aria-label": `joint ${j + 1}`});
        if (limits[0] !== null) { track.setAttribute("aria-valuemin", limits[0]); track.setAttribute("aria-valuemax", limits[1]); }
        track.append(element("i"));
        const middle = element("td"), lamp = element("td");
        middle.append(track);
        lamp.append(element("span", "", {class: "lamp", role: "img"}));
        const number = element("td", `${j + 1}`);
        number.style.borderLeft = `4px solid ${JOINTS[(j + 1) % JOINTS.length]}`;
        number.style.paddingLeft = ".4rem";
        row.append(number, middle, element("td", "", {class: "n"}), lamp);
        return row;
      });
      table.replaceChildren(caption, ...rows);
    }

    _bars() {
      const side = this.sides.at(-1), q = this.q[side] || this.q.before, lamps = this.lamps[side] || this.lamps.before;
      const n = this.data.joints.limits.length, k = Math.round(this.at);
      [...this.show("joints").rows].forEach((row, j) => {
        const value = between(q, n, this.at, j), [low, high] = this.data.joints.limits[j], track = row.querySelector(".track");
        const share = low === null ? 0.5 + value / 720 : (value - low) / (high - low);
        track.firstChild.style.left = `${100 * Math.min(Math.max(share, 0), 1)}%`;
        track.classList.toggle("near", low !== null && (share < 0.05 || share > 0.95));
        track.setAttribute("aria-valuenow", value.toFixed(2));
        row.cells[2].textContent = `${value.toFixed(1)}°`;
        this._lamp(row.querySelector(".lamp"), lamps[k * n + j], k > 0 ? lamps[(k - 1) * n + j] : WITHOUT);
      });
    }

    _lamp(lamp, value, last) {
      const none = value === WITHOUT, unknown = value === UNKNOWN, share = value / 100;
      lamp.style.visibility = none ? "hidden" : "visible";
      lamp.textContent = unknown ? "?" : share > 0.9 ? "+" : share < -0.9 ? "−" : "";
      const [a, b] = [[213, 94, 0], [0, 114, 178]], pale = 1 - Math.abs(share);
      lamp.style.background = unknown || none ? "#fff" : `rgb(${(share > 0 ? a : b).map(v => Math.round(v + pale * (245 - v)))})`;
      lamp.style.color = Math.abs(share) > 0.6 && !unknown ? "#fff" : "#1c2126";
      lamp.classList.toggle("turned", !none && !unknown && last !== WITHOUT && last !== UNKNOWN && Math.sign(last) !== Math.sign(value));
      lamp.setAttribute("aria-label", none ? "" : unknown ? "flank not known" : `flank ${Math.round(value)} %`);
      lamp.title = lamp.getAttribute("aria-label");
    }

    _where() {
      const s = this.data.stations, k = Math.round(this.at), parts = [], size = name => {
        const a = this.arrays[name];
        return Math.hypot(a[3 * k], a[3 * k + 1], a[3 * k + 2]);
      };
      if (s.title) parts.push(s.title[k]);
      if (s.line) parts.push(`line ${s.line[k]}, pose ${s.pose[k]}`, s.cut[k] ? (s.feed[k] === null ? "cut" : `cut, ${s.feed[k]} mm/min`) : "rapid");
      if (this.arrays.deflection) parts.push(`deflection ${said(1e3 * size("deflection"))} mm`);
      if (this.arrays.correction) parts.push(`correction ${said(1e3 * size("correction"))} mm, left ${said(1e6 * this.arrays.remaining[k])} µm`);
      if (this.arrays.force && size("force") > 0) parts.push(`force ${said(size("force"))} N`);
      const show = this.show("where"), text = this.data.texts && s.line && this.data.texts[s.line[k]];
      show.replaceChildren(parts.join(" · "));
      if (text) show.append(element("br"), element("code", text));
    }

    _findings() {
      const entries = this.data.findings.map(f => {
        if (f.station === null) return element("p", f.text);
        const button = element("button", f.text, {type: "button", class: f.level, title: "Go there"});
        button.addEventListener("click", () => { this.pause(); this.go(f.station); });
        return button;
      });
      this.show("findings").replaceChildren(...entries);
      this.show("findings").hidden = !entries.length;
    }
  }
  return View;
})();
