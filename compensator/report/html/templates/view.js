// Edits of the cell: sent to the server, which computes; what comes back is shown. Text goes in as text only.
(() => {
  const form = document.querySelector("[data-edit]");
  if (!form) return;
  const {token, values} = JSON.parse(document.getElementById("view").textContent);
  const told = form.querySelector(".told"), inputs = [...form.querySelectorAll("input[type=number]")];
  let asked = 0, last = "{}";  // edits so far, and the one that is shown or computed

  function edit() {
    const out = {};
    for (const input of inputs) {
      const [table, key, k] = input.name.split("|"), keys = out[table] = out[table] || {};
      (keys[key] = keys[key] || [])[k] = Number(input.value);
    }
    for (const [table, keys] of Object.entries(out)) {
      for (const key of Object.keys(keys)) if (keys[key].every((v, k) => v === values[table][key][k])) delete keys[key];
      if (!Object.keys(keys).length) delete out[table];
    }
    return out;
  }

  function fill(from) {
    for (const input of inputs) {
      const [table, key, k] = input.name.split("|");
      input.value = from[table][key][k];
    }
  }

  function tell(text, refused = false) {
    told.textContent = text;
    told.classList.toggle("refused", refused);
  }

  async function ask(path, content) {
    form.classList.add("busy");
    try {
      const answer = await fetch(path, {
        method: "POST", headers: {"X-Token": token, "Content-Type": "application/json"}, body: JSON.stringify(content)});
      return answer.ok ? await answer.json() : {error: await answer.text()};
    } catch (error) {
      return {error: "the server does not answer: is `compensator view` still running?"};
    } finally {
      form.classList.remove("busy");
    }
  }

  const ofFile = [...document.querySelectorAll(".three div b")].map(value => value.textContent);

  function numbers(list) {
    document.querySelectorAll(".three div").forEach((place, k) => {
      if (!list[k]) return;
      const [value, words, file] = place.children;
      value.textContent = list[k].value;
      words.textContent = list[k].words;
      file.textContent = last === "{}" ? "" : `the cell in the file: ${ofFile[k]}`;
    });
  }

  async function compute() {
    const text = JSON.stringify(edit());
    if (text === last || !form.reportValidity()) return;
    last = text;
    const mine = ++asked, began = performance.now();
    tell("computing …");
    const answer = await ask("/edit", edit());
    if (mine !== asked) return;
    if (answer.error) {
      last = "";
      return tell(answer.error, true);
    }
    window.sceneView.load(answer.scene);
    numbers(answer.numbers);
    tell(`computed in ${((performance.now() - began) / 1000).toFixed(1)} s; the file is as it was`);
  }

  form.addEventListener("submit", event => { event.preventDefault(); compute(); });
  inputs.forEach(input => input.addEventListener("change", () => form.requestSubmit()));
  form.querySelector("[data-act=back]").addEventListener("click", () => { fill(values); compute(); });
  form.querySelector("[data-act=save]").addEventListener("click", async () => {
    const answer = await ask("/save", {name: form.elements.save.value, edit: edit()});
    if (answer.error) tell(answer.error, true); else tell(`saved as ${answer.saved}`);
  });
})();
