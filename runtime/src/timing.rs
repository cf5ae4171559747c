//! What times the passes of a frame.

/// A timer of the host's: a frame announces each of its passes before and after.
pub trait PassTimer {
    /// Announces the next pass, and gives what it writes around itself; nothing without time stamps.
    fn begin(&mut self, label: &str) -> Option<Stamps<'_>>;

    /// Says how many dispatches the pass has that was announced last.
    fn dispatched(&mut self, count: usize);

    /// Ends the pass that was announced last. What `encoder` holds by then may be submitted here.
    fn end(&mut self, encoder: &mut wgpu::CommandEncoder);
}

/// What a compute or render pass writes around itself.
pub struct Stamps<'a> {
    /// Time stamps.
    pub queries: &'a wgpu::QuerySet,
    /// The first of two.
    pub begin: u32,
}

impl<'a> Stamps<'a> {
    /// For a compute pass.
    pub fn compute(&self) -> wgpu::ComputePassTimestampWrites<'a> {
        wgpu::ComputePassTimestampWrites {
            query_set: self.queries,
            beginning_of_pass_write_index: Some(self.begin),
            end_of_pass_write_index: Some(self.begin + 1),
        }
    }

    /// For a render pass.
    pub fn render(&self) -> wgpu::RenderPassTimestampWrites<'a> {
        wgpu::RenderPassTimestampWrites {
            query_set: self.queries,
            beginning_of_pass_write_index: Some(self.begin),
            end_of_pass_write_index: Some(self.begin + 1),
        }
    }
}
