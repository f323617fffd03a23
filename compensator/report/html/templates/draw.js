const figures = JSON.parse(document.getElementById("figures").textContent);
const config = {responsive: true, displaylogo: false, plotlyServerURL: ""};
// a figure is drawn when it comes near the window, so that a long page is there at once; all of them for a printer
const waiting = new Set(Object.keys(figures));
function draw(id) {
  if (!waiting.delete(id)) return;
  const figure = figures[id];
  Plotly.newPlot(id, figure.data, figure.layout, config);
  if (figure.layout.scene2) turnTogether(document.getElementById(id));
}
const near = new IntersectionObserver(
  entries => entries.filter(entry => entry.isIntersecting).forEach(entry => draw(entry.target.id)),
  {rootMargin: "600px"});
for (const [id, figure] of Object.entries(figures)) {
  const place = document.getElementById(id);
  place.style.minHeight = `${figure.layout.height || 120}px`;
  near.observe(place);
}
window.addEventListener("beforeprint", () => [...waiting].forEach(draw));
// both scenes of a figure are looked at from the same side
function turnTogether(drawn) {
  let turning = false;
  drawn.on("plotly_relayout", change => {
    const camera = change["scene.camera"] || change["scene2.camera"];
    if (!camera || turning) return;
    turning = true;
    Plotly.relayout(drawn, {"scene.camera": camera, "scene2.camera": camera}).then(() => { turning = false; });
  });
}
