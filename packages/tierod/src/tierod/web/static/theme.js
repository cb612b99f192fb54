// Before the first picture, so that no light page flashes in the dark.
try {
  const kept = localStorage.getItem("tierod-theme");
  if (kept) document.documentElement.dataset.theme = kept;
} catch (_) { /* no storage: the system's choice holds */ }
