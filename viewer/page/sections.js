// Walks along the vessel: shows the section that the slider asks for.
(() => {
  const view = document.getElementById("section-view");
  const slider = document.getElementById("section-place");
  const image = view.querySelector("image");
  const groups = view.querySelectorAll("g");
  const size = Number(view.dataset.size);
  const show = () => {
    const place = Number(slider.value);
    if (image) image.setAttribute("y", -size / 2 - place * size);
    groups.forEach((group, i) => (i === place ? group.removeAttribute("display") : group.setAttribute("display", "none")));
    const text = groups[place].dataset.text;
    document.getElementById("section-text").textContent = text;
    slider.setAttribute("aria-valuetext", text);
  };
  document.getElementById("section-slider").hidden = false;
  slider.addEventListener("input", show);
  show();
})();
