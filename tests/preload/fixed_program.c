/* A program of the fixed function, as sideray run meets them: GLX, immediate mode, display lists, vertex arrays, a glass
 * pane over a lit floor. fixed_program FRAMES PICTURE.ppm [WHAT...]: draws so many frames and writes the last one. WHAT:
 *   shaders       glUseProgram from the second frame on
 *   contexts      every second frame is drawn in another context
 *   resize        another size of window from the second frame on
 *   lists         the list of the red box is deleted and made anew in each frame
 *   opened        OpenGL's functions come from dlopen, dlsym and glXGetProcAddress
 *   smoke         an unlit, blended quad hangs between the eye and the pane; it is drawn after the pane
 *   overlay       a quad without depth lies over the right half, drawn after the pane
 *   late_box      a box before the pane is drawn after the smoke
 *   stencil       what is drawn after the pane is drawn where the stencil says that the pane is
 *   solid         the pane's alpha is 1
 *   hanging       an opaque box hangs between the sun and the pane
 *   thin          a thin tile, far away, faces the eye and has its back to the sun
 *   water         a blended square lies above the floor, to the right
 *   object, eye, sphere   a textured box stands on the eye's side, its coordinates by glTexGen; with
 *   explicit      they are those of its vertices, and the same
 *   fog           linear fog from 2 to 12
 *   turn          the eye turns from frame to frame
 *   levels        from the second half of the frames on it is another level: lists, textures and the window are made anew;
 *   level2        it is that level from the start
 *   handler       SIGTERM ends it from its handler while it draws the overlay: the context is destroyed, the program exits
 *   swap_handler  the same while it swaps
 *   atexit        the context is destroyed by a function that atexit() was given before anything else
 *   far           the floor's vertices are far from their origin
 *   slow          30 ms pass between frames
 *   egl           EGL in place of GLX
 *   debug         a context for debugging: fails at the first message of an error
 *   error         fails where glGetError has something */
#define GL_GLEXT_PROTOTYPES
#include <EGL/egl.h>
#include <GL/gl.h>
#include <GL/glx.h>
#include <dlfcn.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { width = 320, height = 240 };

static int argument_count;
static char** arguments;

static int has(const char* what) {
  for (int i = 3; i < argument_count; ++i)
    if (strcmp(arguments[i], what) == 0) return 1;
  return 0;
}

static void require(int holds, const char* what) {
  if (holds) return;
  fprintf(stderr, "fixed_program: %s\n", what);
  exit(1);
}

/* The calls that `opened` asks for by name. */
static void (*begin)(GLenum) = glBegin;
static void (*vertex)(GLfloat, GLfloat, GLfloat) = glVertex3f;
static void (*end)(void) = glEnd;
static void (*swap)(Display*, GLXDrawable) = glXSwapBuffers;

static void open_functions(void) {
  void* library = dlopen("libGL.so.1", RTLD_NOW);
  require(library != NULL, "no libGL.so.1");
  __GLXextFuncPtr (*by_name)(const GLubyte*) = NULL;
  *(void**)&by_name = dlsym(library, "glXGetProcAddressARB");
  require(by_name != NULL, "no glXGetProcAddressARB");
  begin = (void (*)(GLenum))by_name((const GLubyte*)"glBegin");
  vertex = (void (*)(GLfloat, GLfloat, GLfloat))by_name((const GLubyte*)"glVertex3f");
  *(void**)&end = dlsym(library, "glEnd");
  *(void**)&swap = dlsym(library, "glXSwapBuffers");
}

static void box(float x, float y, float z, float size) {
  static const float corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  static const int face[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 4, 7, 3}, {1, 2, 6, 5}};
  static const float normal[6][3] = {{0, 0, -1}, {0, 0, 1}, {0, -1, 0}, {0, 1, 0}, {-1, 0, 0}, {1, 0, 0}};
  glBegin(GL_QUADS);
  for (int f = 0; f < 6; ++f) {
    glNormal3fv(normal[f]);
    for (int k = 0; k < 4; ++k) {
      const float* c = corner[face[f][k]];
      glVertex3f(x + size * c[0], y + size * c[1], z + size * c[2]);
    }
  }
  glEnd();
}

static void draw_thin_tile(void) {
  static const float normal[3] = {0, -0.8f, 0.6f};
  glColor3f(0.9f, 0.8f, 0.1f);
  for (int back = 0; back < 2; ++back) {
    const float side = back ? -1 : 1, up = 3.4f + (back ? 0.016f : 0), z = -6 - (back ? 0.012f : 0);
    glNormal3f(side * normal[0], side * normal[1], side * normal[2]);
    glBegin(GL_QUADS);
    glVertex3f(-1, up - 0.3f, z - 0.4f);
    glVertex3f(1, up - 0.3f, z - 0.4f);
    glVertex3f(1, up + 0.3f, z + 0.4f);
    glVertex3f(-1, up + 0.3f, z + 0.4f);
    glEnd();
  }
}

static GLuint make_box_list(GLuint old, int level) {
  if (old) glDeleteLists(old, 1);
  const GLuint list = glGenLists(1);
  glNewList(list, GL_COMPILE);
  glColor3f(level == 2 ? 0.2f : 0.9f, 0.1f, level == 2 ? 0.9f : 0.1f);
  box(level == 2 ? 0.3f : -0.5f, 0, 1.5f, 1);
  glEndList();
  return list;
}

/* Texture coordinates as glTexGen makes them; `planes` are the identity, set while MODELVIEW is. */
static void set_coordinates(const float* m, const float* position, const float* normal) {
  float eye[3], n[3];
  for (int row = 0; row < 3; ++row) {
    eye[row] = m[row] * position[0] + m[4 + row] * position[1] + m[8 + row] * position[2] + m[12 + row];
    n[row] = m[row] * normal[0] + m[4 + row] * normal[1] + m[8 + row] * normal[2];
  }
  if (has("object")) glTexCoord2f(position[0], position[1]);
  if (has("eye")) glTexCoord2f(eye[0], eye[1]);
  if (!has("sphere")) return;
  const float length = sqrtf(eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2]);
  float along = 0, r[3];
  for (int c = 0; c < 3; ++c) along += 2 * n[c] * eye[c] / length;
  for (int c = 0; c < 3; ++c) r[c] = eye[c] / length - along * n[c];
  const float scale = 2 * sqrtf(r[0] * r[0] + r[1] * r[1] + (r[2] + 1) * (r[2] + 1));
  glTexCoord2f(r[0] / scale + 0.5f, r[1] / scale + 0.5f);
}

static void generate_coordinates(void) {
  static const float planes[2][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}};
  glPushMatrix();
  glLoadIdentity();
  for (int c = 0; c < 2; ++c) {
    glTexGeni(GL_S + (GLenum)c, GL_TEXTURE_GEN_MODE, has("object") ? GL_OBJECT_LINEAR : has("eye") ? GL_EYE_LINEAR : GL_SPHERE_MAP);
    glTexGenfv(GL_S + (GLenum)c, GL_OBJECT_PLANE, planes[c]);
    glTexGenfv(GL_S + (GLenum)c, GL_EYE_PLANE, planes[c]);
    glEnable(GL_TEXTURE_GEN_S + (GLenum)c);
  }
  glPopMatrix();
}

static GLuint make_checkers(int level) {
  unsigned char texels[16 * 16][4];
  for (int i = 0; i < 256; ++i) {
    const unsigned char on = (unsigned char)((i % 16 / 4 + i / 64) % 2 ? 230 : 60);
    texels[i][0] = texels[i][1] = texels[i][2] = on;
    if (level == 2) texels[i][1] = 20;
    texels[i][3] = 255;
  }
  GLuint texture;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, 16, 16, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels);
  return texture;
}

/* A textured wall between the eye and the pane, beside the box, that faces the pane. */
static void draw_textured_wall(void) {
  static GLuint texture = 0;
  if (texture == 0) texture = make_checkers(2);
  static const float corner[4][3] = {{-1.6f, 0, 1}, {-1.6f, 1.5f, 1}, {-0.6f, 1.5f, 1.2f}, {-0.6f, 0, 1.2f}}, normal[3] = {0.196f, 0, -0.981f};
  glEnable(GL_TEXTURE_2D);
  glBindTexture(GL_TEXTURE_2D, texture);
  if (!has("explicit")) generate_coordinates();
  float modelview[16];
  glGetFloatv(GL_MODELVIEW_MATRIX, modelview);
  glColor3f(1, 1, 0.5f);
  glNormal3fv(normal);
  glBegin(GL_QUADS);
  for (int k = 0; k < 4; ++k) {
    if (has("explicit")) set_coordinates(modelview, corner[k], normal);
    glVertex3fv(corner[k]);
  }
  glEnd();
  glDisable(GL_TEXTURE_GEN_S);
  glDisable(GL_TEXTURE_GEN_T);
  glDisable(GL_TEXTURE_2D);
}

static void set_fog(void) {
  static const float color[4] = {0.1f, 0.2f, 0.9f, 1};
  glEnable(GL_FOG);
  glFogi(GL_FOG_MODE, GL_LINEAR);
  glFogf(GL_FOG_START, 2);
  glFogf(GL_FOG_END, 12);
  glFogfv(GL_FOG_COLOR, color);
}

static void draw_floor(GLuint texture) {
  float positions[] = {-4, 0, -4, -4, 0, 4, 4, 0, 4, 4, 0, -4};
  const float far_away = has("far") ? 4321.7f : 0;
  for (int i = 0; i < 12; i += 3) positions[i] += far_away, positions[i + 2] -= far_away;
  static const float uvs[] = {0, 0, 0, 4, 4, 4, 4, 0};
  static const GLubyte indices[] = {0, 1, 2, 0, 2, 3};
  glEnable(GL_TEXTURE_2D);
  glBindTexture(GL_TEXTURE_2D, texture);
  glColor3f(1, 1, 1);
  glNormal3f(0, 1, 0);
  glEnableClientState(GL_VERTEX_ARRAY);
  glEnableClientState(GL_TEXTURE_COORD_ARRAY);
  glVertexPointer(3, GL_FLOAT, 0, positions);
  glTexCoordPointer(2, GL_FLOAT, 0, uvs);
  glPushMatrix();
  glTranslatef(-far_away, 0, far_away);
  glDrawElements(GL_TRIANGLES, 6, GL_UNSIGNED_BYTE, indices);
  glPopMatrix();
  glDisableClientState(GL_VERTEX_ARRAY);
  glDisableClientState(GL_TEXTURE_COORD_ARRAY);
  glDisable(GL_TEXTURE_2D);
}

static void quad(float x0, float x1, float y0, float y1, float z) {
  begin(GL_QUADS);
  vertex(x0, y0, z);
  vertex(x1, y0, z);
  vertex(x1, y1, z);
  vertex(x0, y1, z);
  end();
}

/* An upright pane between the eye and the middle of the floor; what it reflects stands behind the eye's side. */
static void draw_pane(void) {
  if (has("stencil")) {
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(GL_ALWAYS, 1, 255);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  }
  glNormal3f(0, 0, 1);
  glColor4f(0.2f, 0.4f, 0.3f, has("solid") ? 1 : 0.3f);
  quad(-1.5f, 1.5f, 0.1f, 2, 0);
  if (has("stencil")) glStencilFunc(GL_EQUAL, 1, 255);
}

/* Of arrays: a rule can name it. */
static void draw_water(void) {
  static const float corners[] = {1.6f, 0.4f, -2, 1.6f, 0.4f, 2, 3.6f, 0.4f, 2, 3.6f, 0.4f, -2};
  glNormal3f(0, 1, 0);
  glColor4f(0.1f, 0.3f, 0.5f, 0.2f);
  glEnableClientState(GL_VERTEX_ARRAY);
  glVertexPointer(3, GL_FLOAT, 0, corners);
  glDrawArrays(GL_QUADS, 0, 4);
  glDisableClientState(GL_VERTEX_ARRAY);
}

static void draw_smoke(void) {
  glDisable(GL_LIGHTING);
  glColor4f(1, 1, 0, 0.5f);
  quad(-0.4f, 0.4f, 0.4f, 1.4f, 0.6f);
  glEnable(GL_LIGHTING);
}

static void draw_late_box(void) {
  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);
  glColor3f(0.9f, 0.9f, 0.1f);
  box(-1.3f, 0.6f, 0.4f, 0.6f);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
}

static void let_signals_in(int let) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigprocmask(let ? SIG_UNBLOCK : SIG_BLOCK, &set, NULL);
}

static void draw_overlay(void) {
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_LIGHTING);
  glMatrixMode(GL_PROJECTION);
  glLoadIdentity();
  glMatrixMode(GL_MODELVIEW);
  glLoadIdentity();
  glColor4f(0, 0, 1, 0.5f);
  quad(0, 1, -1, 1, 0);
}

static void draw_frame(GLuint box_list, GLuint checkers, int w, int h, int frame) {
  static const GLfloat sun[4] = {0.3f, 1, 0.6f, 0};
  glViewport(0, 0, w, h);
  glClearColor(0.3f, 0.5f, 0.8f, 1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  glEnable(GL_DEPTH_TEST);
  glMatrixMode(GL_PROJECTION);
  glLoadIdentity();
  glFrustum(-0.1 * w / h, 0.1 * w / h, -0.1, 0.1, 0.2, 50);
  glMatrixMode(GL_MODELVIEW);
  glLoadIdentity();
  glRotatef(12, 1, 0, 0);
  if (has("turn")) glRotatef(0.2f * (float)frame, 0, 1, 0);
  glTranslatef(0, -1.8f, -4.5f);
  glLightfv(GL_LIGHT0, GL_POSITION, sun);
  glEnable(GL_LIGHT0);
  glEnable(GL_LIGHTING);
  glEnable(GL_COLOR_MATERIAL);
  if (has("fog")) set_fog();
  draw_floor(checkers);
  if (has("object") || has("eye") || has("sphere")) draw_textured_wall();
  glCallList(box_list);
  glColor3f(0.2f, 0.8f, 0.2f);
  box(-0.3f, 0, -2, 0.8f);
  if (has("hanging")) box(0.7f, 1.75f, 0.5f, 0.5f);
  if (has("thin")) draw_thin_tile();
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(GL_FALSE);
  draw_pane();
  if (has("water")) draw_water();
  if (has("smoke")) draw_smoke();
  if (has("late_box")) draw_late_box();
  glDisable(GL_STENCIL_TEST);
  if (has("handler")) let_signals_in(1);
  if (has("overlay")) draw_overlay();
  if (has("handler")) let_signals_in(0);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
}

static void write_picture(const char* path, int w, int h) {
  unsigned char* pixels = malloc((size_t)(3 * w * h));
  FILE* file = fopen(path, "wb");
  require(pixels && file, "the picture cannot be written");
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, w, h, GL_RGB, GL_UNSIGNED_BYTE, pixels);
  fprintf(file, "P6 %d %d 255\n", w, h);
  for (int y = h - 1; y >= 0; --y) fwrite(pixels + 3 * y * w, 3, (size_t)w, file);
  fclose(file);
  free(pixels);
}

static GLuint make_program(void) {
  static const char* text = "void main() { gl_FragColor = gl_Color; }";
  const GLuint shader = glCreateShader(GL_FRAGMENT_SHADER), program = glCreateProgram();
  glShaderSource(shader, 1, &text, NULL);
  glCompileShader(shader);
  glAttachShader(program, shader);
  glLinkProgram(program);
  return program;
}

static void APIENTRY hear(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length, const GLchar* text, const void* user) {
  (void)source, (void)id, (void)severity, (void)length, (void)user;
  require(type != GL_DEBUG_TYPE_ERROR, text);
}

/* The ways to a context. */
struct Screen {
  Display* display;
  Window window;
  GLXContext contexts[2];
  EGLDisplay egl;
  EGLSurface surface;
};

static XVisualInfo* find_visual(Display* display) {
  int attributes[] = {GLX_RGBA, GLX_DOUBLEBUFFER, GLX_DEPTH_SIZE, 24, GLX_STENCIL_SIZE, 8, None};
  return glXChooseVisual(display, DefaultScreen(display), attributes);
}

static GLXContext make_debug_context(Display* display) {
  int wanted[] = {GLX_DOUBLEBUFFER, True, GLX_DEPTH_SIZE, 24, GLX_STENCIL_SIZE, 8, None}, count = 0;
  int attributes[] = {GLX_CONTEXT_FLAGS_ARB, GLX_CONTEXT_DEBUG_BIT_ARB, None};
  GLXFBConfig* configs = glXChooseFBConfig(display, DefaultScreen(display), wanted, &count);
  PFNGLXCREATECONTEXTATTRIBSARBPROC create = NULL;
  *(void**)&create = (void*)glXGetProcAddress((const GLubyte*)"glXCreateContextAttribsARB");
  require(configs != NULL && count > 0 && create != NULL, "no context for debugging");
  return create(display, configs[0], NULL, True, attributes);
}

static void make_egl_context(struct Screen* screen) {
  const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_DEPTH_SIZE, 24, EGL_STENCIL_SIZE, 8, EGL_NONE};
  EGLConfig config;
  EGLint count = 0;
  screen->egl = eglGetDisplay((EGLNativeDisplayType)screen->display);
  require(eglInitialize(screen->egl, NULL, NULL) && eglBindAPI(EGL_OPENGL_API), "no EGL");
  require(eglChooseConfig(screen->egl, wanted, &config, 1, &count) && count == 1, "no configuration of EGL");
  screen->surface = eglCreateWindowSurface(screen->egl, config, screen->window, NULL);
  const EGLContext context = eglCreateContext(screen->egl, config, EGL_NO_CONTEXT, NULL);
  require(eglMakeCurrent(screen->egl, screen->surface, screen->surface, context) == EGL_TRUE, "no context of EGL");
}

static struct Screen open_screen(void) {
  struct Screen screen = {XOpenDisplay(NULL), 0, {NULL, NULL}, EGL_NO_DISPLAY, EGL_NO_SURFACE};
  Display* display = screen.display;
  require(display != NULL, "no display");
  XVisualInfo* visual = find_visual(display);
  require(visual != NULL, "no visual of GLX");
  XSetWindowAttributes attributes = {0};
  const Window root = RootWindow(display, visual->screen);
  attributes.colormap = XCreateColormap(display, root, visual->visual, AllocNone);
  screen.window = XCreateWindow(display, root, 0, 0, width, height, 0, visual->depth, InputOutput, visual->visual, CWColormap, &attributes);
  XMapWindow(display, screen.window);
  if (has("egl")) {
    make_egl_context(&screen);
    return screen;
  }
  screen.contexts[0] = has("debug") ? make_debug_context(display) : glXCreateContext(display, visual, NULL, True);
  screen.contexts[1] = has("contexts") ? glXCreateContext(display, visual, screen.contexts[0], True) : screen.contexts[0];
  glXMakeCurrent(display, screen.window, screen.contexts[0]);
  return screen;
}

static void close_screen(struct Screen* screen) {
  if (has("egl")) {
    const EGLContext context = eglGetCurrentContext();
    eglMakeCurrent(screen->egl, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(screen->egl, context);
  } else {
    glXMakeCurrent(screen->display, None, NULL);
    glXDestroyContext(screen->display, screen->contexts[0]);
  }
  XCloseDisplay(screen->display);
}

static struct Screen* open_one;

/* Waits for the X server, and for the driver's threads. */
static void leave(int number) {
  XSync(open_one->display, False);
  glXMakeCurrent(open_one->display, None, NULL);
  glXDestroyContext(open_one->display, open_one->contexts[0]);
  XCloseDisplay(open_one->display);
  exit(number == SIGTERM ? 3 : 4);
}

/* What has been freed by then is overwritten. */
static void close_at_exit(void) {
  for (size_t size = 8; size < 512; size += 8)
    for (int i = 0; i < 64; ++i) memset(malloc(size), 'x', size);
  close_screen(open_one);
}

static void resize(const struct Screen* screen, int w, int h) {
  XResizeWindow(screen->display, screen->window, (unsigned)w, (unsigned)h);
  XSync(screen->display, False);
}

int main(int argc, char** argv) {
  require(argc >= 3, "usage: fixed_program FRAMES PICTURE.ppm [WHAT...]");
  argument_count = argc, arguments = argv;
  const int frames = atoi(argv[1]);
  if (has("atexit")) atexit(close_at_exit);
  static struct Screen screen;
  screen = open_screen();
  if (has("opened")) open_functions();
  open_one = &screen;
  if (has("handler") || has("swap_handler")) let_signals_in(0), signal(SIGTERM, leave);
  if (has("debug")) {
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(hear, NULL);
  }
  int level = has("level2") ? 2 : 1, w = width, h = height;
  GLuint checkers = make_checkers(level), program = has("shaders") ? make_program() : 0;
  GLuint box_list = make_box_list(0, level);
  for (int frame = 0; frame < frames; ++frame) {
    if (has("contexts")) glXMakeCurrent(screen.display, screen.window, screen.contexts[frame % 2]);
    if (has("levels") && frame == frames / 2) {
      level = 2;
      glDeleteTextures(1, &checkers);
      checkers = make_checkers(level);
      box_list = make_box_list(box_list, level);
    }
    if ((has("resize") && frame == 1) || (has("levels") && frame == frames / 2) || (has("level2") && frame == 0)) resize(&screen, w = 400, h = 200);
    if (has("lists")) box_list = make_box_list(box_list, level);
    if (program && frame > 0) glUseProgram(program);
    draw_frame(box_list, checkers, w, h, frame);
    if (frame == frames - 1) write_picture(argv[2], w, h);
    if (has("error")) require(glGetError() == GL_NO_ERROR, "an OpenGL error");
    if (has("slow")) usleep(30000);
    if (has("swap_handler")) let_signals_in(1);
    if (has("egl"))
      eglSwapBuffers(screen.egl, screen.surface);
    else
      swap(screen.display, screen.window);
    if (has("swap_handler")) let_signals_in(0);
  }
  if (!has("atexit")) close_screen(&screen);
  return 0;
}
