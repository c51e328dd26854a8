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
 *   error         fails where glGetError has something */
#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glx.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

static GLuint make_box_list(GLuint old) {
  if (old) glDeleteLists(old, 1);
  const GLuint list = glGenLists(1);
  glNewList(list, GL_COMPILE);
  glColor3f(0.9f, 0.1f, 0.1f);
  box(-0.5f, 0, 1.5f, 1);
  glEndList();
  return list;
}

static GLuint make_checkers(void) {
  unsigned char texels[16 * 16][4];
  for (int i = 0; i < 256; ++i) {
    const unsigned char on = (unsigned char)((i % 16 / 4 + i / 64) % 2 ? 230 : 60);
    texels[i][0] = texels[i][1] = texels[i][2] = on;
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

static void draw_floor(GLuint texture) {
  static const float positions[] = {-4, 0, -4, -4, 0, 4, 4, 0, 4, 4, 0, -4}, uvs[] = {0, 0, 0, 4, 4, 4, 4, 0};
  static const GLubyte indices[] = {0, 1, 2, 0, 2, 3};
  glEnable(GL_TEXTURE_2D);
  glBindTexture(GL_TEXTURE_2D, texture);
  glColor3f(1, 1, 1);
  glNormal3f(0, 1, 0);
  glEnableClientState(GL_VERTEX_ARRAY);
  glEnableClientState(GL_TEXTURE_COORD_ARRAY);
  glVertexPointer(3, GL_FLOAT, 0, positions);
  glTexCoordPointer(2, GL_FLOAT, 0, uvs);
  glDrawElements(GL_TRIANGLES, 6, GL_UNSIGNED_BYTE, indices);
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
  box(-2.2f, 0.2f, 1.2f, 0.6f);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
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

static void draw_frame(GLuint box_list, GLuint checkers, int w, int h) {
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
  glTranslatef(0, -1.8f, -4.5f);
  glLightfv(GL_LIGHT0, GL_POSITION, sun);
  glEnable(GL_LIGHT0);
  glEnable(GL_LIGHTING);
  glEnable(GL_COLOR_MATERIAL);
  draw_floor(checkers);
  glCallList(box_list);
  glColor3f(0.2f, 0.8f, 0.2f);
  box(-0.3f, 0, -2, 0.8f);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(GL_FALSE);
  draw_pane();
  if (has("smoke")) draw_smoke();
  if (has("late_box")) draw_late_box();
  glDisable(GL_STENCIL_TEST);
  if (has("overlay")) draw_overlay();
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

int main(int argc, char** argv) {
  require(argc >= 3, "usage: fixed_program FRAMES PICTURE.ppm [WHAT...]");
  argument_count = argc, arguments = argv;
  const int frames = atoi(argv[1]);
  Display* display = XOpenDisplay(NULL);
  require(display != NULL, "no display");
  int attributes[] = {GLX_RGBA, GLX_DOUBLEBUFFER, GLX_DEPTH_SIZE, 24, GLX_STENCIL_SIZE, 8, None};
  XVisualInfo* visual = glXChooseVisual(display, DefaultScreen(display), attributes);
  require(visual != NULL, "no visual of GLX");
  XSetWindowAttributes window_attributes = {0};
  const Window root = RootWindow(display, visual->screen);
  window_attributes.colormap = XCreateColormap(display, root, visual->visual, AllocNone);
  const Window window = XCreateWindow(display, root, 0, 0, width, height, 0, visual->depth, InputOutput, visual->visual, CWColormap, &window_attributes);
  XMapWindow(display, window);
  GLXContext contexts[2] = {glXCreateContext(display, visual, NULL, True), NULL};
  contexts[1] = has("contexts") ? glXCreateContext(display, visual, contexts[0], True) : contexts[0];
  glXMakeCurrent(display, window, contexts[0]);
  if (has("opened")) open_functions();
  const GLuint checkers = make_checkers(), program = has("shaders") ? make_program() : 0;
  GLuint box_list = make_box_list(0);
  int w = width, h = height;
  for (int frame = 0; frame < frames; ++frame) {
    if (has("contexts")) glXMakeCurrent(display, window, contexts[frame % 2]);
    if (has("resize") && frame == 1) {
      w = 400, h = 200;
      XResizeWindow(display, window, (unsigned)w, (unsigned)h);
      XSync(display, False);
    }
    if (has("lists")) box_list = make_box_list(box_list);
    if (program && frame > 0) glUseProgram(program);
    draw_frame(box_list, checkers, w, h);
    if (frame == frames - 1) write_picture(argv[2], w, h);
    if (has("error")) require(glGetError() == GL_NO_ERROR, "an OpenGL error");
    swap(display, window);
  }
  glXMakeCurrent(display, None, NULL);
  glXDestroyContext(display, contexts[0]);
  XCloseDisplay(display);
  return 0;
}
