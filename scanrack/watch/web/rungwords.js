// Completions while a rung is typed: instructions, then tags. Tags of the routine's own program have short names.

import { matching } from "./completing.js";
import { draft } from "./draft.js";
import { run } from "./state.js";

export const tagsOf = routine => [
  ...draft.tags.map(([name, type]) => ({ text: name, says: `${type}, new` })),
  ...(run.hello.tags ?? []).map(each => ({ text: shortName(each.name, routine), says: each.type })),
];

function shortName(name, routine) {
  const own = /^\\[^.]+\./.exec(routine)?.[0];
  return own && name.toUpperCase().startsWith(own.toUpperCase()) ? name.slice(own.length) : name;
}

export function offered(typed, routine) {
  const [, before, word] = /^(.*?)([^\s,(]*)$/s.exec(typed), name = typed.trim().split(/[\s,(]/)[0].toUpperCase();
  if (!before.trim())
    return word
      ? {
          from: before.length,
          found: matching(
            word,
            draft.words.instructions.map(each => ({ text: each.name, says: each.operands.join(", ") }))
          ).filter(each => each.text.startsWith(word.toUpperCase())),
        }
      : null;
  if (!word) return null;
  const found = matching(word, tagsOf(routine)), bits = draft.words.instructions.find(each => each.name === name)?.bits;
  return {
    from: before.length,
    found: bits
      ? [
          ...found.filter(each => each.says.startsWith("BOOL")),
          ...found.filter(each => !each.says.startsWith("BOOL")),
        ]
      : found,
  };
}

export function offeredInText(typed, routine) {
  const [, before, word] = /^(.*?)([\w.:\\]*)$/s.exec(typed);
  return word && /[(,]$/.test(before) ? { from: before.length, found: matching(word, tagsOf(routine)) } : null;
}
