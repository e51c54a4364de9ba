//! The window: events from the system, pictures to the screen. The only file that names winit, softbuffer and arboard.

use super::{
    draw::{Scale, Surface},
    event::{Button, Event},
    link::Link,
    picture::{News, Picture},
    renderer::beside,
    setting::Setting,
    ui::{Ui, Wish},
};
use crate::{
    error::{Error, Result},
    render::RenderOptions,
    scene::Scene,
};
use std::num::NonZeroU32;
use std::rc::Rc;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use winit::{
    application::ApplicationHandler,
    dpi::{LogicalSize, PhysicalPosition, PhysicalSize},
    event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent},
    event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy, OwnedDisplayHandle},
    keyboard::{Key, NamedKey},
    window::{Fullscreen, Window, WindowId},
};

/// Pixels of a touch pad's scrolling that are a step of the wheel.
const PIXELS_PER_STEP: f64 = 40.0;

/// What the renderer's thread wakes the window for.
#[derive(Debug)]
enum Wake {
    /// There is a picture in the box.
    Picture,
    /// A sentence for the user.
    Note(String),
    /// The renderer has ended.
    Ended,
}

/// Shows the scene in a window until the user closes it.
///
/// # Errors
/// [`Error::Failed`] if there is no display, and as [`beside`].
pub fn open(scene: &Scene, options: &RenderOptions, frame_time: Duration) -> Result<()> {
    let events = EventLoop::<Wake>::with_user_event().build().map_err(no_display)?;
    events.set_control_flow(ControlFlow::Wait);
    let (link, latest) = (Link::default(), Mutex::new(None::<Box<Picture>>));
    let mut ended = Ended(events.create_proxy());
    let tell = |news| match news {
        News::Picture(picture) => {
            let old = latest.lock().unwrap_or_else(PoisonError::into_inner).replace(picture);
            if let Some(old) = old {
                link.give_back(old.pixels);
            }
            ended.wake(Wake::Picture);
        }
        News::Rest { .. } => {}
        News::Note(note) => ended.wake(Wake::Note(note)),
    };
    beside(scene, options, frame_time, &link, tell, || {
        link.send(Event::Set(Setting::Play(true)));
        link.send(Event::Set(Setting::AntiAliasing(true)));
        let mut app = App {
            link: &link,
            latest: &latest,
            title: format!("irt - {}", scene.name),
            wanted: options.size,
            ui: Ui::with_figures(),
            screen: None,
            picture: None,
            cursor: None,
            button: None,
            clipboard: None,
            failure: None,
        };
        events.run_app(&mut app).map_err(no_display)?;
        app.failure.map_or(Ok(()), Err)
    })
}

fn no_display(error: impl std::fmt::Display) -> Error {
    Error::Failed(format!(
        "no window can be opened ({error}); set DISPLAY or WAYLAND_DISPLAY, or use --terminal or --script"
    ))
}

/// Wakes the window, at last when the renderer ends, however it ends.
struct Ended(EventLoopProxy<Wake>);

impl Ended {
    fn wake(&mut self, wake: Wake) {
        // Fails when the window is gone; then nobody needs to be woken.
        let _ = self.0.send_event(wake);
    }
}

impl Drop for Ended {
    fn drop(&mut self) {
        self.wake(Wake::Ended);
    }
}

/// A window and its memory.
struct Screen {
    window: Rc<Window>,
    surface: softbuffer::Surface<OwnedDisplayHandle, Rc<Window>>,
}

struct App<'a> {
    link: &'a Link,
    latest: &'a Mutex<Option<Box<Picture>>>,
    title: String,
    wanted: [u32; 2],
    ui: Ui,
    screen: Option<Screen>,
    /// What is shown.
    picture: Option<Box<Picture>>,
    cursor: Option<PhysicalPosition<f64>>,
    button: Option<(MouseButton, Button)>,
    clipboard: Option<arboard::Clipboard>,
    failure: Option<Error>,
}

impl ApplicationHandler<Wake> for App<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.screen.is_some() {
            return;
        }
        match self.screen(events) {
            Ok(screen) => {
                self.resize(screen.window.inner_size());
                self.screen = Some(screen);
            }
            Err(error) => {
                self.failure = Some(error);
                events.exit();
            }
        }
    }

    fn user_event(&mut self, events: &ActiveEventLoop, wake: Wake) {
        match wake {
            Wake::Picture => {
                if let Some(picture) = self.latest.lock().unwrap_or_else(PoisonError::into_inner).take() {
                    self.ui.note_picture(&picture);
                    if let Some(old) = self.picture.replace(picture) {
                        self.link.give_back(old.pixels);
                    }
                }
                self.redraw();
            }
            Wake::Note(note) => {
                self.ui.note = Some(note);
                self.redraw();
            }
            Wake::Ended => events.exit(),
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => events.exit(),
            WindowEvent::Resized(size) => self.resize(size),
            WindowEvent::Focused(false) => {
                self.button = None;
                self.link.send(Event::ReleaseAll);
            }
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => self.key(&event, events),
            WindowEvent::CursorMoved { position, .. } => self.drag(position),
            WindowEvent::MouseInput { state, button, .. } => self.press(state, button),
            WindowEvent::MouseWheel { delta, .. } => {
                let steps = match delta {
                    MouseScrollDelta::LineDelta(_, steps) => steps,
                    MouseScrollDelta::PixelDelta(by) => (by.y / PIXELS_PER_STEP) as f32,
                };
                self.link.send(Event::Wheel(steps));
            }
            WindowEvent::RedrawRequested => {
                if let Err(error) = self.draw() {
                    self.failure = Some(error);
                    events.exit();
                }
            }
            _ => {}
        }
    }
}

impl App<'_> {
    fn screen(&self, events: &ActiveEventLoop) -> Result<Screen> {
        let [width, height] = self.wanted;
        let attributes = Window::default_attributes()
            .with_title(&self.title)
            .with_inner_size(LogicalSize::new(width, height));
        let window = Rc::new(events.create_window(attributes).map_err(no_display)?);
        let context = softbuffer::Context::new(events.owned_display_handle()).map_err(no_display)?;
        let surface = softbuffer::Surface::new(&context, Rc::clone(&window)).map_err(no_display)?;
        Ok(Screen { window, surface })
    }

    fn resize(&self, size: PhysicalSize<u32>) {
        // A window that is folded away has no size; the picture stays.
        if size.width > 0 && size.height > 0 {
            self.link.send(Event::Resize([size.width, size.height]));
        }
    }

    fn redraw(&self) {
        if let Some(screen) = &self.screen {
            screen.window.request_redraw();
        }
    }

    fn key(&mut self, event: &KeyEvent, events: &ActiveEventLoop) {
        let down = event.state == ElementState::Pressed;
        let Some(name) = name_of(&event.logical_key).filter(|_| !event.repeat) else { return };
        for wish in self.ui.key(&name, down) {
            match wish {
                Wish::Send(Event::Quit) => events.exit(),
                Wish::Send(event) => self.link.send(event),
                Wish::Copy(text) => self.copy(&text),
                Wish::FullScreen => self.full_screen(),
                Wish::Redraw => self.redraw(),
            }
        }
    }

    /// To the clipboard, and for those without one to the log.
    fn copy(&mut self, text: &str) {
        log::info!("{text}");
        if self.clipboard.is_none() {
            self.clipboard = arboard::Clipboard::new().ok();
        }
        let copied = self.clipboard.as_mut().is_some_and(|clipboard| clipboard.set_text(text).is_ok());
        if !copied {
            self.ui.note = Some(format!("there is no clipboard: {text}"));
        }
    }

    fn full_screen(&self) {
        if let Some(Screen { window, .. }) = &self.screen {
            let full = window.fullscreen().is_some();
            window.set_fullscreen((!full).then_some(Fullscreen::Borderless(None)));
        }
    }

    fn press(&mut self, state: ElementState, button: MouseButton) {
        let meaning = match button {
            MouseButton::Left => Button::Left,
            MouseButton::Right | MouseButton::Middle => Button::Right,
            _ => return,
        };
        match state {
            ElementState::Pressed => self.button = Some((button, meaning)),
            ElementState::Released if self.button.is_some_and(|(held, _)| held == button) => {
                self.button = None;
            }
            ElementState::Released => {}
        }
    }

    fn drag(&mut self, position: PhysicalPosition<f64>) {
        let old = self.cursor.replace(position).unwrap_or(position);
        let scale = self.screen.as_ref().map_or(1.0, |screen| screen.window.scale_factor());
        if let Some((_, button)) = self.button {
            let by = [position.x - old.x, position.y - old.y].map(|pixels| (pixels / scale) as f32);
            self.link.send(Event::Drag(button, by));
        }
    }

    fn draw(&mut self) -> Result<()> {
        let (Some(screen), Some(picture)) = (&mut self.screen, &self.picture) else { return Ok(()) };
        let PhysicalSize { width, height } = screen.window.inner_size();
        let (Some(w), Some(h)) = (NonZeroU32::new(width), NonZeroU32::new(height)) else { return Ok(()) };
        screen.surface.resize(w, h).map_err(lost)?;
        let mut buffer = screen.surface.buffer_mut().map_err(lost)?;
        let scale = if screen.window.scale_factor() > 1.4 { Scale::Large } else { Scale::Small };
        let mut surface = Surface { size: [width, height], pixels: &mut buffer };
        self.ui.compose(picture, &mut surface, scale);
        screen.window.pre_present_notify();
        buffer.present().map_err(lost)
    }
}

fn lost(error: softbuffer::SoftBufferError) -> Error {
    Error::Failed(format!("the window cannot be drawn ({error}); open it again"))
}

/// The name of a key as in the bindings.
fn name_of(key: &Key) -> Option<String> {
    Some(match key {
        Key::Character(text) => text.to_lowercase(),
        Key::Named(named) => match named {
            NamedKey::ArrowLeft => "left",
            NamedKey::ArrowRight => "right",
            NamedKey::ArrowUp => "up",
            NamedKey::ArrowDown => "down",
            NamedKey::Shift => "shift",
            NamedKey::Escape => "escape",
            NamedKey::Home => "home",
            NamedKey::Tab => "tab",
            NamedKey::Space => "space",
            NamedKey::F1 => "f1",
            NamedKey::F11 => "f11",
            _ => return None,
        }
        .into(),
        _ => return None,
    })
}
