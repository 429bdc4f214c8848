// Opens the scene when it is asked for: until then its program and its data are text.
(() => {
  const inflate = async (id) => {
    const packed = Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  };
  const button = document.getElementById("scene-open");
  const place = document.getElementById("scene");
  button.hidden = false;
  button.addEventListener("click", async () => {
    button.disabled = true;
    button.textContent = "Opening …";
    try {
      const script = document.createElement("script");
      script.textContent = new TextDecoder().decode(await inflate("scene-program"));
      document.head.append(script);
      window.angioSceneView = window.angioScene.open(place, await inflate("scene-data"));
    } catch (error) {
      place.dataset.state = "failed";
      place.textContent = "The scene cannot be drawn here: it needs WebGL 2 (" + error.message + ").";
    }
  });
})();
