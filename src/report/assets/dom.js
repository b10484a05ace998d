/* Elements of the page. Text goes in as text only. */

const element = (tag, properties, ...children) => {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children.flat().filter(child => child !== null && child !== undefined));
  return made;
};

const optionList = (choices, chosen) =>
  choices.map(([value, text]) => element("option", {value, selected: value === chosen}, text));

/* A long table: folded to its heading where the window is narrow. */
const longTable = (heading, rows, ...content) => {
  const folded = rows > 6 && matchMedia("(max-width: 40rem)").matches;
  return element("details", {className: "table", open: !folded},
                 element("summary", {}, element("h3", {}, heading)), ...content);
};
