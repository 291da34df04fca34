"""The table of materials, which the site makes of ``continuum/maps/verdict/materials.toml``."""

from continuum.inputs.units import readable
from continuum.maps.verdict.materials import materials


def table() -> str:
    """Materials of predictions, each with the sources of its values."""
    rows, sources = [], []
    for name, one in materials().items():
        work = "-" if one.work_of_adhesion is None else readable(one.work_of_adhesion, "energy_per_area", 3)
        moduli = [readable(modulus, "pressure", 3) for modulus in (one.modulus, one.plane_strain_modulus)]
        rows.append(f"| `{name}` | {moduli[0]} | {one.poisson:.3g} | {moduli[1]} | {work} | {one.range * 1e9:.3g} nm |")
        sources.append(f"* `{name}`: {'; '.join(one.sources)}")
    head = [
        "# Materials",
        "",
        "Values of `--material NAME`; [Is my surface sticky?](../predict.md#materials) explains them. Without a w (-)"
        " give `--work`: clean metals weld, and others carry oxides. Diamond and rubber have the paper's 50 mJ/m². For"
        " crystals E* is that of one face, and differs from E/(1-ν²): (100) of silicon, germanium and gallium arsenide,"
        " the basal plane of graphite and mica.",
        "",
    ]
    head += ["| material | E | ν | E* | w | range |", "|---|---|---|---|---|---|"]
    return "\n".join([*head, *rows, "", "## Sources", "", *sources, ""])
