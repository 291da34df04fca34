/* fix wall/crystal: a rigid crystal of any shape above a surface, whose atoms act on those below by a pair law, as a
   plugin of LAMMPS.

   Syntax

     plugin load crystal.so
     fix ID group wall/crystal FILE separation D keyword values ...

     FILE        the atoms of the crystal over the period of the box, and the pair law (see below)
     separation  D of the plane z = 0 of FILE above z = surface: a number, or v_name of a variable
     offset      X Y of the crystal: numbers, or v_name of variables; 0 0 by default
     surface     z of the surface from which the separation counts; 0 by default
     units       L E: units of length and energy of FILE and of the keywords in those of LAMMPS; 1 1 by default

   The law is that of Lennard-Jones less its tangent at the cut-off, so that energy and force end there without a jump:
   V(r) = v(r) - v(c) - (r - c) v'(c) with v(r) = 4 e ((s/r)^12 - (s/r)^6), as pair_style lj/smooth/linear.

   FILE, in text: "law DEPTH SIGMA CUTOFF", "period X Y", "atoms N" and N lines "x y z".  Lines that begin with # are
   comments.

   Output: a global scalar, the energy (fix_modify energy yes adds it to that of the system); a global vector, the force
   on the atoms along x, y and z; a per-atom array: force along x, y and z, and energy, in the units of FILE. */

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix.h"
#include "input.h"
#include "lammps.h"
#include "memory.h"
#include "update.h"
#include "utils.h"
#include "variable.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

using namespace LAMMPS_NS;
using namespace FixConst;

namespace {

struct Site {
  double x[3];
};

/* A number, or the name of a variable. */
struct Quantity {
  std::string name;
  double value = 0.0;
};

class FixWallCrystal : public Fix {
 public:
  FixWallCrystal(LAMMPS *, int, char **);
  ~FixWallCrystal() override { memory->destroy(array_atom); }
  int setmask() override { return POST_FORCE | MIN_POST_FORCE; }
  void init() override;
  void setup(int vflag) override { post_force(vflag); }
  void min_setup(int vflag) override { post_force(vflag); }
  void min_post_force(int vflag) override { post_force(vflag); }
  void post_force(int) override;
  double compute_scalar() override { return all()[3]; }
  double compute_vector(int i) override { return all()[i]; }
  double memory_usage() override { return 8.0 * (4.0 * nmax + 3.0 * atoms); }

 private:
  int nmax = 0, atoms = 0, bins[2] = {1, 1};
  std::vector<std::vector<Site>> sites;    // of each column of the period, about a0 wide
  double depth = 0.0, sigma = 1.0, cutoff = 0.0, lowest = 0.0, period[2] = {1.0, 1.0};
  double energy_at_end = 0.0, slope_at_end = 0.0;
  Quantity separation, offset[2], surface;
  double length = 1.0, energy = 1.0;
  double mine[4], summed[4];    // forces along x, y and z, and energy
  bool is_summed = false;

  void read(const std::string &);
  Quantity quantity(const char *);
  double now(const Quantity &);
  void act(const double *, double *) const;
  const double *all();
};

FixWallCrystal::FixWallCrystal(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  if (narg < 6 || strcmp(arg[4], "separation") != 0)
    error->all(FLERR, "fix wall/crystal needs a file and a separation");
  separation = quantity(arg[5]);
  auto left = [&](int i, int count) {
    if (i + count >= narg) error->all(FLERR, std::string("fix wall/crystal: values of ") + arg[i] + " are missing");
  };
  for (int i = 6; i < narg;) {
    const std::string keyword = arg[i];
    if (keyword == "offset") {
      left(i, 2);
      for (int axis = 0; axis < 2; axis++) offset[axis] = quantity(arg[i + 1 + axis]);
      i += 3;
    } else if (keyword == "surface") {
      left(i, 1);
      surface = quantity(arg[i + 1]);
      i += 2;
    } else if (keyword == "units") {
      left(i, 2);
      length = utils::numeric(FLERR, arg[i + 1], false, lmp);
      energy = utils::numeric(FLERR, arg[i + 2], false, lmp);
      i += 3;
    } else
      error->all(FLERR, "fix wall/crystal: unknown keyword " + keyword);
  }
  if (!(length > 0.0 && energy > 0.0)) error->all(FLERR, "fix wall/crystal: units are positive");
  if (domain->triclinic || !domain->xperiodic || !domain->yperiodic)
    error->all(FLERR, "fix wall/crystal needs a rectangular box that is periodic along x and y");
  read(arg[3]);
  for (int axis = 0; axis < 2; axis++)
    if (std::fabs(period[axis] * length - domain->prd[axis]) > 1e-9 * domain->prd[axis])
      error->all(FLERR, "fix wall/crystal: the period of the crystal is not that of the box");
  scalar_flag = vector_flag = peratom_flag = 1;
  size_vector = 3;
  extscalar = extvector = 1;
  global_freq = peratom_freq = 1;
  size_peratom_cols = 4;
  energy_global_flag = 1;
  memory->create(array_atom, nmax = std::max(atom->nmax, 1), 4, "wall/crystal:array_atom");
  memset(&array_atom[0][0], 0, sizeof(double) * 4 * nmax);
  memset(mine, 0, sizeof(mine));
}

Quantity FixWallCrystal::quantity(const char *text)
{
  if (strncmp(text, "v_", 2) == 0) return {text + 2, 0.0};
  return {"", utils::numeric(FLERR, text, false, lmp)};
}

double FixWallCrystal::now(const Quantity &q)
{
  if (q.name.empty()) return q.value;
  if (input->variable->find(q.name.c_str()) < 0) error->all(FLERR, "fix wall/crystal: there is no variable " + q.name);
  return input->variable->compute_equal("v_" + q.name);    // index-style variables, too
}

void FixWallCrystal::read(const std::string &name)
{
  std::string text;
  if (comm->me == 0) {
    std::ifstream file(name);
    if (!file) error->one(FLERR, "fix wall/crystal cannot open " + name);
    for (std::string line; std::getline(file, line);)
      if (line.empty() || line[0] != '#') text += line + '\n';
  }
  int size = text.size();
  MPI_Bcast(&size, 1, MPI_INT, 0, world);
  text.resize(size);
  MPI_Bcast(&text[0], size, MPI_CHAR, 0, world);
  std::istringstream words(text);
  std::string word;
  if (!(words >> word >> depth >> sigma >> cutoff) || word != "law" || !(sigma > 0.0 && cutoff > 0.0))
    error->all(FLERR, name + " does not begin with a law");
  if (!(words >> word >> period[0] >> period[1]) || word != "period" || !(period[0] > 0.0 && period[1] > 0.0))
    error->all(FLERR, name + " does not go on with a period");
  if (!(words >> word >> atoms) || word != "atoms" || atoms < 1)
    error->all(FLERR, name + " does not go on with atoms");
  for (int axis = 0; axis < 2; axis++) bins[axis] = std::max(1, static_cast<int>(period[axis]));
  sites.resize(static_cast<size_t>(bins[0]) * bins[1]);
  lowest = INFINITY;
  for (int n = 0; n < atoms; n++) {
    Site site;
    int bin[2];
    words >> site.x[0] >> site.x[1] >> site.x[2];
    for (int axis = 0; axis < 2; axis++) {
      site.x[axis] -= period[axis] * std::floor(site.x[axis] / period[axis]);
      bin[axis] = std::min(bins[axis] - 1, static_cast<int>(site.x[axis] / period[axis] * bins[axis]));
    }
    lowest = std::min(lowest, site.x[2]);
    sites[static_cast<size_t>(bin[0]) * bins[1] + bin[1]].push_back(site);
  }
  if (!words) error->all(FLERR, name + " ends before its atoms do");
  const double s6 = std::pow(sigma / cutoff, 6);
  energy_at_end = 4.0 * depth * s6 * (s6 - 1.0);
  slope_at_end = -24.0 * depth * s6 * (2.0 * s6 - 1.0) / cutoff;
}

void FixWallCrystal::init()
{
  if (utils::strmatch(update->integrate_style, "^respa")) error->all(FLERR, "fix wall/crystal knows no rRESPA");
}

/* Force on an atom at a place in the frame of the crystal, and energy. */
void FixWallCrystal::act(const double *at, double *found) const
{
  memset(found, 0, 4 * sizeof(double));
  if (at[2] + cutoff < lowest) return;
  int first[2], last[2];
  for (int axis = 0; axis < 2; axis++) {
    const double per = bins[axis] / period[axis];
    first[axis] = static_cast<int>(std::floor((at[axis] - cutoff) * per));
    last[axis] = static_cast<int>(std::floor((at[axis] + cutoff) * per));
  }
  for (int i = first[0]; i <= last[0]; i++) {
    const int image_x = static_cast<int>(std::floor(static_cast<double>(i) / bins[0]));
    for (int j = first[1]; j <= last[1]; j++) {
      const int image_y = static_cast<int>(std::floor(static_cast<double>(j) / bins[1]));
      const size_t column = static_cast<size_t>(i - image_x * bins[0]) * bins[1] + (j - image_y * bins[1]);
      for (const Site &site : sites[column]) {
        const double d[3] = {at[0] - site.x[0] - image_x * period[0], at[1] - site.x[1] - image_y * period[1],
                             at[2] - site.x[2]};
        const double r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        if (r2 >= cutoff * cutoff) continue;
        const double r = std::sqrt(r2), s2 = sigma * sigma / r2, s6 = s2 * s2 * s2;
        const double slope = -24.0 * depth * s6 * (2.0 * s6 - 1.0) / r - slope_at_end;
        for (int k = 0; k < 3; k++) found[k] -= slope * d[k] / r;
        found[3] += 4.0 * depth * s6 * (s6 - 1.0) - energy_at_end - (r - cutoff) * slope_at_end;
      }
    }
  }
}

void FixWallCrystal::post_force(int)
{
  if (atom->nmax > nmax) {
    memory->destroy(array_atom);
    memory->create(array_atom, nmax = atom->nmax, 4, "wall/crystal:array_atom");
    memset(&array_atom[0][0], 0, sizeof(double) * 4 * nmax);
  }
  const double level = now(separation) + now(surface), shift[2] = {now(offset[0]), now(offset[1])};
  const double force = energy / length;
  double **x = atom->x, **f = atom->f;
  const int *mask = atom->mask;
  memset(mine, 0, sizeof(mine));
  for (int i = 0; i < atom->nlocal; i++) {
    double *out = array_atom[i];
    if (!(mask[i] & groupbit)) {
      memset(out, 0, 4 * sizeof(double));
      continue;
    }
    const double at[3] = {(x[i][0] - domain->boxlo[0]) / length - shift[0],
                          (x[i][1] - domain->boxlo[1]) / length - shift[1], x[i][2] / length - level};
    act(at, out);
    for (int k = 0; k < 3; k++) {
      f[i][k] += out[k] * force;
      mine[k] += out[k] * force;
    }
    mine[3] += out[3] * energy;
  }
  is_summed = false;
}

const double *FixWallCrystal::all()
{
  if (!is_summed) MPI_Allreduce(mine, summed, 4, MPI_DOUBLE, MPI_SUM, world);
  is_summed = true;
  return summed;
}

Fix *create(LAMMPS *lmp, int narg, char **arg) { return new FixWallCrystal(lmp, narg, arg); }

/* What LAMMPS is told of a plugin: as in its lammpsplugin.h, which an installed LAMMPS comes without. */
struct Plugin {
  const char *version, *style, *name, *info, *author;
  Fix *(*creator)(LAMMPS *, int, char **);
  void *handle;
};

}    // namespace

extern "C" void lammpsplugin_init(void *lmp, void *handle, void *regfunc)
{
  Plugin plugin = {static_cast<LAMMPS *>(lmp)->version, "fix", "wall/crystal",
                   "rigid crystal of any shape by a pair law", "stickiness", &create, handle};
  reinterpret_cast<void (*)(Plugin *, void *)>(regfunc)(&plugin, lmp);
}
