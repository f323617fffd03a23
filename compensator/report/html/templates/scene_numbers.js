// Numbers of a scene: unpacked arrays, colours, and sums of placements.
const SceneNumbers = (() => {
  const KINDS = {f: Float32Array, u: Uint32Array, s: Uint16Array, b: Uint8Array, i: Int8Array};
  function unpacked(text, kind = "f") {
    const bytes = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
    return new KINDS[kind](bytes.buffer);
  }
  // viridis by its corners: colour-blind readers can tell them apart, and it prints in grey
  const STOPS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
  const JOINTS = ["#b4bac0", "#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9", "#000000", "#777777"];
  const GREY = [0.62, 0.66, 0.7];
  function mapped(share) {
    const at = Math.min(Math.max(share, 0), 1) * (STOPS.length - 1), k = Math.min(Math.floor(at), STOPS.length - 2);
    return [0, 1, 2].map(i => (STOPS[k][i] + (at - k) * (STOPS[k + 1][i] - STOPS[k][i])) / 255);
  }
  function jointColour(number) {
    const text = JOINTS[number % JOINTS.length];
    return [1, 3, 5].map(i => parseInt(text.slice(i, i + 2), 16) / 255);
  }
  function range(values, cut) {
    let low = Infinity, high = -Infinity;
    for (let k = 0; k < values.length; k++) {
      if (!cut[k] || !Number.isFinite(values[k])) continue;
      low = Math.min(low, values[k]);
      high = Math.max(high, values[k]);
    }
    return high < low ? [0, 1] : [Math.min(low, 0), Math.max(high, 1e-9)];
  }
  const digits = value => Math.abs(value) >= 100 ? 0 : Math.abs(value) >= 10 ? 1 : Math.abs(value) >= 1 ? 2 : 3;
  const said = value => Number.isFinite(value) ? value.toFixed(digits(value)) : "–";
  // entry i of what stands at a station that need not be whole: a line between its neighbours
  function between(values, width, at, i) {
    const k = Math.floor(at), share = at - k, here = values[k * width + i];
    return share > 0 ? here + share * (values[(k + 1) * width + i] - here) : here;
  }
  return {unpacked, mapped, jointColour, JOINTS, GREY, STOPS, range, said, between};
})();
