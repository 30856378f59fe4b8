"""What the chart of a page may show, as its own module tells."""

CURVES = """async () => {
  const [{ Motion }, { quantities }] = await Promise.all([import("omnisim/motion"), import("omnisim/quantities")]);
  const data = JSON.parse(document.getElementById("data").textContent);
  return quantities(new Motion(data.motion), data.machine.wheels);
}"""
