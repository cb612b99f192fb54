// The page: navigation, theme, and the view that the address names.
import { html, stack, render, useEffect, useErrorBoundary, useState } from "./html.js";
import { site as served } from "./api.js";
import { follow, useAddress } from "./address.js";
import { Trouble, useFetched } from "./parts.js";
import { Files } from "./files.js";
import { Recording } from "./recording.js";
import { New } from "./new.js";
import { Identify } from "./identify.js";
import { Fleet } from "./fleet.js";
import { Vehicle } from "./vehicle.js";
import { Scenario } from "./scenario.js";
import { Live } from "./live.js";
import { Interface, JobList } from "./jobs.js";

const VIEWS = { "": [Files, "Recordings"], new: [New, "New recording"], identify: [Identify, "Identify"], fleet: [Fleet, "Fleet"], vehicle: [Vehicle, "Vehicle"], scenario: [Scenario, "Scenario"], live: [Live, "Live"], jobs: [JobList, "Work"], interface: [Interface, ""], recording: [Recording, ""] };

function Theme() {
  const dark = () => (document.documentElement.dataset.theme || (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light")) === "dark";
  const [now, put] = useState(dark());
  const turn = () => {
    const next = dark() ? "light" : "dark";
    document.documentElement.dataset.theme = next;
    try { localStorage.setItem("tierod-theme", next); } catch (_) { /* not kept then */ }
    put(next === "dark");
    dispatchEvent(new Event("tierod-theme"));
  };
  return stack`<button onClick=${turn} aria-pressed=${now} title="Light or dark">${now ? "Dark" : "Light"}</button>`;
}

function Shell() {
  const address = useAddress();
  const site = useFetched(served, []);
  const [View, title] = VIEWS[address.view] || VIEWS[""];
  useEffect(() => { document.title = `${address.file ? `${address.file.split("/").pop()} · ` : title ? `${title} · ` : ""}tierod`; }, [address.view, address.file]);
  const current = address.view === "recording" ? "" : address.view;
  return stack`<a class="skip" href="#content">To the content</a>
    <header class="top"><a class="brand" href="/">tierod</a><nav class="views" aria-label="Views">${Object.entries(VIEWS).filter(([, [, name]]) => name).map(([view, [, name]]) => html`<a key=${view} href=${`/${view}`} aria-current=${view === current ? "page" : undefined}>${name}</a>`)}</nav>
      <a class="small" href="/interface">Interface</a><${Theme} /></header>
    <main id="content" tabindex="-1">${site.error ? html`<${Trouble} error=${site.error} again=${site.again} />` : html`<${Bounded} key=${address.view}><${View} address=${address} site=${site.data} /><//>`}</main>`;
}

function Bounded({ children }) {
  const [error, again] = useErrorBoundary((found) => console.error(found));
  return error ? html`<${Trouble} error=${{ message: `the page has a defect (${error.message}); reload it, and report it if it comes again` }} again=${again} />` : children;
}

document.addEventListener("click", follow);
const place = document.getElementById("app");
place.textContent = "";
render(html`<${Shell} />`, place);
