const figures = JSON.parse(document.getElementById("figures").textContent);
const config = {responsive: true, displaylogo: false, plotlyServerURL: ""};
for (const [id, figure] of Object.entries(figures)) {
  Plotly.newPlot(id, figure.data, figure.layout, config);
  if (figure.layout.scene2) turnTogether(document.getElementById(id));
}
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
