/* Elements of the page. Text goes in as text only. */

const element = (tag, properties, ...children) => {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children.flat().filter(child => child !== null && child !== undefined));
  return made;
};

const optionList = (choices, chosen) =>
  choices.map(([value, text]) => element("option", {value, selected: value === chosen}, text));
