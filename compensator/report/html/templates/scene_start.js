(() => {
  const root = document.querySelector("[data-scene]"), {before, after} = root.dataset;
  window.sceneView = new SceneView(root, JSON.parse(document.getElementById("scene").textContent), {before, after});
})();
