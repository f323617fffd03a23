window.sceneView = new SceneView(
  document.querySelector("[data-scene]"), JSON.parse(document.getElementById("scene").textContent),
  {before: "as the file stands", after: "with the program"});
