// The way from the camera in the hand to the proposed view: an arrow in the picture of the camera.
function showGuidance({ arrow_m: [right, down, forward], distance_m: away, angle_deg: turn, reached }) {
  byId("guidance").hidden = false;
  byId("guidance").classList.toggle("reached", reached);
  byId("arrow").setAttribute("transform", `rotate(${Math.atan2(right, -down) * 180 / Math.PI})`);
  const part = (value, positive, negative) =>
    Math.abs(value) < 0.005 ? [] : [`${lengthText(Math.abs(value))} ${value > 0 ? positive : negative}`];
  const way = [...part(right, "right", "left"), ...part(down, "down", "up"), ...part(forward, "forward", "back")];
  byId("guidance-text").textContent = reached
    ? "Here it is: hold still."
    : `${lengthText(away)} to go: ${way.join(", ") || "stay there"}; turn by ${Math.round(turn)}°.`;
}

// A camera in this pose, with the lens of the scan.
function cameraAt(rows, lens) {
  const turned = (point) => rows.slice(0, 3).map((row) => dot(row, point));
  return { position: rows.slice(0, 3).map((row) => row[3]), corners: lens.map(turned) };
}

function showTracking({ lost, remedy }) {
  byId("tracking").hidden = !lost;
  byId("tracking").textContent = lost ? `The camera's place is lost. ${remedy || "Go back to where it was last known."}` : "";
}
