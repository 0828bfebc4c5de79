// The site's search: pages that answer come first, tables that name everything come last.
const LAST = /^(rules-amci3601|readings|commands|check-rules|adapter-tables|decisions\/|api$|watch-socket)/;
var Scorer = {
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
  score: ([page, , , , score]) => (LAST.test(page) ? score / 100 : page === "tasks" ? score + 20 : score),
};
