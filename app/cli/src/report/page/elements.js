// Elements that all pages share.

const header = document.getElementById("header");
const main = document.getElementById("main");

const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

// A number for people, with about four digits.
const short = (x, digits = 4) => {
  if (!Number.isFinite(x)) return "–";
  if (x === 0) return "0";
  const size = Math.abs(x);
  if (size < 1e-4 || size >= 1e6) return x.toExponential(2);
  return String(Number(x.toPrecision(digits)));
};

// An element with a class, text and children.
const element = (name, className = "", text = "", children = []) => {
  const made = document.createElement(name);
  if (className) made.className = className;
  if (text) made.textContent = text;
  made.append(...children);
  return made;
};

const svgOf = (text) => document.importNode(new DOMParser().parseFromString(text, "image/svg+xml").documentElement, true);

const button = (text, title, action) => {
  const made = element("button", "", text);
  made.type = "button";
  made.title = title;
  made.setAttribute("aria-label", title);
  made.addEventListener("click", action);
  return made;
};

const panel = (title, children, open = true) => {
  const made = element("details", "panel", "", [element("summary", "", title), ...children]);
  made.open = open;
  return made;
};

// A switch in the header between light and dark; the default is the system's. `changed` is called after each change.
const followTheme = (changed) => {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const set = (theme) => {
    document.documentElement.dataset.theme = theme;
    changed();
  };
  const other = () => set(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  const made = button("◐", "light or dark", other);
  made.classList.add("theme");
  header.append(made);
  dark.addEventListener("change", () => set(dark.matches ? "dark" : "light"));
  set(dark.matches ? "dark" : "light");
};
