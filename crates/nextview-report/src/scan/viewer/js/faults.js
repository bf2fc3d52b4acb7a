// What went wrong, of the last action and of the last look at the server each.
const shownFaults = { action: null, look: null };

function showFault(of, error) {
  shownFaults[of] = error;
  const errors = Object.values(shownFaults).filter(Boolean);
  byId("failure").hidden = !errors.length;
  byId("failure").textContent = [...new Set(errors.map((fault) => fault.message))].join("; ");
  if (errors.some(({ status }) => status === 401)) byId("token-form").hidden = false;
}
