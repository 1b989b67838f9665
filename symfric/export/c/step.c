
/* What follows calls the functions above; neither allocates memory nor has loops of unknown length. */
#include "scene_.h"

const double scene__parameters[SCENE__ARRAY(SCENE__PARAMETERS)] = {@VALUES@};
const double scene__initial[SCENE__ARRAY(SCENE__STATES)] = {@INITIAL@};

void scene__begin(scene__state *s, const double *p, const double *v) {
  const double *arg[@START_ARG@] = {s->x, &s->t, p, v, 0};
  double *res[@START_RES@] = {s->x, s->memory};
  casadi_int iw[@START_IW@];
  double w[@START_W@];
  s->origin = s->t;
  s->steps = 0;
  scene__graph_start(arg, res, iw, w, 0);
}

void scene__reset(scene__state *s, const double *p, const double *v) {
  int k;
  s->t = 0;
  for (k = 0; k < SCENE__STATES; k++) s->x[k] = scene__initial[k];
  scene__begin(s, p, v);
}

int scene__advance(scene__state *s, const double *p, const double *v, const double *dv, double h) {
  double status = 0, x[SCENE__ARRAY(SCENE__STATES)], memory[SCENE__ARRAY(SCENE__MEMORY)];
  const double *arg[@ADVANCE_ARG@] = {x, memory, &s->t, p, v, dv, &h};
  double *res[@ADVANCE_RES@] = {s->x, s->memory, &status};
  casadi_int iw[@ADVANCE_IW@];
  double w[@ADVANCE_W@];
  int k;
  for (k = 0; k < SCENE__STATES; k++) x[k] = s->x[k];
  for (k = 0; k < SCENE__MEMORY; k++) memory[k] = s->memory[k];
  scene__graph_advance(arg, res, iw, w, 0);
  s->t += h;
  return (int)status;
}

int scene__step(scene__state *s, const double *p, const double *v, const double *dv) {
  int status;
  if (s->t != s->origin + s->steps * SCENE__STEP) {
    s->origin = s->t;
    s->steps = 0;
  }
  status = scene__advance(s, p, v, dv, SCENE__STEP);
  s->steps += 1;
  s->t = s->origin + s->steps * SCENE__STEP;
  return status;
}

void scene__look(const scene__state *s, const double *p, const double *v, double *outputs, double *modes) {
  const double *arg[@LOOK_ARG@] = {s->x, s->memory, &s->t, p, v};
  double *res[@LOOK_RES@] = {outputs, modes};
  casadi_int iw[@LOOK_IW@];
  double w[@LOOK_W@];
  scene__graph_look(arg, res, iw, w, 0);
}
