
"use strict";
document.documentElement.classList.add("scripted");

const pickers = [...document.querySelectorAll(".picker")];
for (const picker of pickers) {
  const select = picker.querySelector("select");
  const show = () => {
    for (const part of document.querySelectorAll("[data-metric]")) part.hidden = part.dataset.metric !== select.value;
  };
  picker.hidden = false;
  select.addEventListener("change", show);
  // A browser may have kept a choice.
  show();
}

for (const compare of document.querySelectorAll(".compare")) {
  const slide = compare.querySelector(".slide");
  const pair = compare.querySelector(".pair");
  const move = () => pair.style.setProperty("--at", slide.value + "%");
  slide.hidden = false;
  slide.addEventListener("input", move);
  // A browser keeps what was chosen before a page was loaded again.
  move();
}

for (const explorer of document.querySelectorAll(".explorer")) {
  const readout = explorer.querySelector(".readout");
  const filter = explorer.querySelector(".filter");
  const dots = [...explorer.querySelectorAll(".dot")];
  const rows = [...explorer.parentElement.querySelectorAll("tr[data-key]")].filter((row) => {
    return row.closest("section") === explorer.closest("section");
  });
  const chosen = [...filter.querySelectorAll("select")];
  const place = (dot) => dot.querySelector(".disc, circle, polygon, path").getBoundingClientRect();

  readout.hidden = false;
  readout.textContent = "Point at a configuration to read about it here.";
  const tell = (dot) => { readout.textContent = dot.getAttribute("aria-label"); };

  const fits = (key) => {
    const values = key.split(",");
    return chosen.every((select) => select.value === "" || values[select.dataset.axis] === select.value);
  };
  const narrow = () => {
    const all = chosen.every((select) => select.value === "");
    let left = 0;
    for (const dot of dots) {
      const fit = fits(dot.dataset.key);
      dot.classList.toggle("dim", !fit);
      dot.classList.toggle("lit", fit && !all);
      left += fit;
    }
    for (const row of rows) row.classList.toggle("dim", !fits(row.dataset.key));
    filter.querySelector("output").textContent = all ? "" : left + " of " + dots.length + " configurations";
  };
  filter.hidden = chosen.length === 0;
  for (const select of chosen) select.addEventListener("change", narrow);
  // As with the slides, a browser may have kept a choice.
  narrow();

  for (const dot of dots) {
    dot.addEventListener("pointerenter", () => tell(dot));
    dot.addEventListener("focus", () => tell(dot));
    dot.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (step === undefined) return;
      event.preventDefault();
      const seen = dots.filter((other) => !other.classList.contains("dim"));
      seen.sort((one, other) => place(one).left - place(other).left);
      const next = seen[seen.indexOf(dot) + step];
      if (next) next.focus();
    });
  }
}

for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.querySelectorAll("thead th")];
  heads.forEach((head, column) => {
    if (head.textContent === "") return;
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = head.textContent;
    head.replaceChildren(button);
    let up = false;
    button.addEventListener("click", () => {
      up = !up;
      for (const other of heads) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", up ? "ascending" : "descending");
      const of = (row) => row.cells[column].dataset.value ?? row.cells[column].textContent;
      const order = (one, other) => {
        const [a, b] = [of(one), of(other)];
        const difference = Number(a) - Number(b);
        return Number.isNaN(difference) ? a.localeCompare(b) : difference;
      };
      const rows = [...table.tBodies[0].rows].sort((one, other) => (up ? order(one, other) : order(other, one)));
      table.tBodies[0].append(...rows);
    });
  });
}
