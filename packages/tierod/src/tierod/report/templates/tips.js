"use strict";
// The explanation of a term over it, while the pointer or the focus is there; a tap shows it and a further one hides it.
(() => {
  const tip = document.createElement("div");
  tip.className = "tip";
  tip.hidden = true;
  tip.setAttribute("aria-hidden", "true"); // the link is described by the same words for a screen reader
  document.body.append(tip);
  let shown = null, leaving = 0;

  const term = (event) => event.target.closest && event.target.closest("a.term");
  const explained = (link) => document.getElementById(decodeURIComponent(link.hash.slice(1)));

  function show(link) {
    clearTimeout(leaving);
    const words = explained(link);
    if (!words || shown === link) return;
    shown = link;
    tip.textContent = words.querySelector("dd").textContent;
    tip.hidden = false;
    const at = link.getBoundingClientRect(), own = tip.getBoundingClientRect();
    const below = at.bottom + own.height + 8 < window.innerHeight;
    tip.style.left = Math.max(8, Math.min(at.left, window.innerWidth - own.width - 8)) + "px";
    tip.style.top = (below ? at.bottom + 4 : Math.max(4, at.top - own.height - 4)) + "px";
  }
  function hide() {
    shown = null;
    tip.hidden = true;
  }
  const later = () => { leaving = setTimeout(hide, 150); };

  document.addEventListener("pointerover", (event) => {
    if (event.pointerType === "touch") return;
    const link = term(event);
    if (link) show(link);
    else if (tip.contains(event.target)) clearTimeout(leaving);
    else if (shown && document.activeElement !== shown) later();
  });
  document.addEventListener("focusin", (event) => (term(event) ? show(term(event)) : hide()));
  document.addEventListener("keydown", (event) => { if (event.key === "Escape") hide(); });
  document.addEventListener("scroll", hide, { passive: true });
  let touched = false;
  document.addEventListener("pointerdown", (event) => { touched = event.pointerType === "touch"; }, true);
  document.addEventListener("click", (event) => {
    const link = term(event);
    if (!link) return hide();
    if (touched) {
      event.preventDefault();
      if (tip.dataset.of === link.hash && !tip.hidden && tip.dataset.tapped) { delete tip.dataset.tapped; return hide(); }
      show(link);
      tip.dataset.of = link.hash;
      tip.dataset.tapped = "yes";
      return;
    }
    open(explained(link));
  });

  // What a link leads to may lie in a fold.
  function open(place) {
    for (let fold = place && place.closest("details"); fold; fold = fold.parentElement.closest("details")) fold.open = true;
  }
  const followed = () => {
    const place = location.hash.length > 1 && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (place) { open(place); place.scrollIntoView(); }
  };
  window.addEventListener("hashchange", followed);
  if (location.hash) followed();
})();
